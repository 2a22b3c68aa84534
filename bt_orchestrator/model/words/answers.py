"""The sentences with which the node answers requests that it carries out, by kind."""

from __future__ import annotations

from collections.abc import Mapping

ANSWERS: Mapping[str, str] = {
    # the cell
    'told_late': 'the reason of the {verb} is on record',
    'gets_ready': 'the cell gets ready',
    'starts': 'the cell starts',
    'finishes': 'the cell finishes the cycles in hand and stops',
    'paused_until': 'the cell starts nothing more until hold {hold} is over',
    'still_paused': 'still paused: {words}',
    'cell_goes_on': 'the cell goes on',
    'paused_no_more': 'no longer paused; it waits for answers to {named_holds}',
    'goals_cancelled': '{count} goals are being cancelled',
    'goal_cancelled': '1 goal is being cancelled',
    'cancelled_unrecorded': '{words}; this is not on record: {what}. Make room or mend the file, '
    'start the orchestrator again and say abort once more: it does not know of this one',
    'belt_confirmed': 'the belt is confirmed; the cell stops, reset and start let it go on',
    'line_goes_on': 'the line goes on',
    'stop_after_item': 'the cell stops after the current item',
    'stop_after_job': 'the cell stops after the current job',
    'twin_stops': 'the cell starts nothing more: {words}',
    # where it is asked from, and manual mode
    'now_local': 'the line is in local: only its panels move it, and what runs goes on',
    'now_remote': 'the line is in remote: everybody moves it who may',
    'now_manual': 'the cell is in manual mode: it stands until production, and runs single goals',
    'manual_over': 'manual mode has ended; reset and start let the cell go on',
    'task_sent': '{task} is sent to {component}',
    'task_cancelled': '{task} at {component} is being cancelled',
    'heard': 'heard',
    # holds, stops and items
    'answered': 'hold {hold}: {answer}',
    'classified': 'the stop has the reason {code}',
    'item_off': '{item} is off the belt',
    # components
    'now_in_service': '{component} is in service',
    'now_out': '{component} is out of service: no goal is sent to it (this is no lockout)',
    'runs_on': '{task} runs there and goes on to its end',
    'passed': 'passed in the queue, because they need it: {jobs}',
    'passed_by_recipe': 'by recipe, and made anew without it where that can be: {jobs}',
    'line_needs': '{job} on the line needs {components} and waits',
    'items_need': 'its items on the line still need {components} and wait',
    'items_go_on': 'in-service lets it go on, or an engineer takes its items off (remove-item) or '
    'aborts it (job abort {job})',
    'requeue_rest': 'to make the rest without it now: job requeue {job}',
    'stop_and_queue': 'to make the rest otherwise, stop it (job stop {job}) and queue the rest '
    'anew',
    # the queue
    'queued': 'queued',
    'job_queued': '{job} is queued',
    'job_queued_held': '{job} is queued and held',
    'awaits_start': 'it waits for its start, {moment}',
    'awaits_start_released': 'it waits for its start, {moment}; release it again to let it start '
    'at once',
    'panel_releases': 'the line is in local: a panel has to release what was queued',
    'awaits_way': 'the cell waits for {way}, for {who} said {verb}',
    'awaits_way_why': 'the cell waits for {way}, for {who} said {verb}: {words}',
    'awaits_way_soon': 'when it has stopped, the cell waits for {way}, for {who} said {verb}',
    'awaits_way_soon_why': 'when it has stopped, the cell waits for {way}, for {who} said {verb}: '
    '{words}',
    'job_updated': '{job} is updated',
    'rest_queued': '{job} is queued first, with {count} items',
    'rest_queued_anew': '{job} is queued first, with {count} items, {anew}',
    'rest_queued_1': '{job} is queued first, with 1 item',
    'rest_queued_1_anew': '{job} is queued first, with 1 item, {anew}',
    'job_placed': '{job} is at position {position}',
    'job_next': '{job} is next',
    'arranged': 'the order of the queue is {jobs}',
    'made_anew': 'made anew',
    'made_anew_at': 'made anew: {pace}',
    'made_anew_with': 'made anew with {components}',
    'made_anew_with_at': 'made anew with {components}: {pace}',
    'made_anew_without': 'made anew without {components}',
    'made_anew_without_at': 'made anew without {components}: {pace}',
    'per_item': '{seconds} s per item',
    'per_item_changed': '{seconds} s per item ({share})',
    'made_as_before': '{job} is made as before',
    # jobs
    'job_is_held': '{job} is held',
    'job_released': '{job} is released',
    'job_begins_none': '{job} begins no more items',
    'job_goes_on': '{job} goes on',
    'job_another_piece': '{job} makes another first piece',
    'job_runs_out': '{job} ends when its items on the line are finished',
    'job_aborting': '{job} is being aborted',
    'job_out': '{job} is out of the queue',
    'job_unlisted': '{job} is no longer listed',
    # releases of scripts
    'script_released': '{script} is released for this cell',
    'script_released_for': '{script} is released for this cell; it was waited for by {jobs}',
}
