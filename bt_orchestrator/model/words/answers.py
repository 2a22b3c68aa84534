"""The sentences with which requests are answered, by kind."""

from __future__ import annotations

from collections.abc import Mapping

REFUSALS: Mapping[str, str] = {
    # who may ask, and from where
    'not_for_role': '{request} is for the role {roles}, and {who} has the role {role} ({known}); '
    'nothing was done',
    'not_for_role_with': '{request} with {parameter} is for the role {roles}, and {who} has the '
    'role {role} ({known}); nothing was done',
    'role_not_trusted': 'the role {claims} does not count, since the node does not trust that '
    'door',
    'role_of_ros': 'the parameter unauthenticated_role of the node is the role of everybody in '
    'the ROS domain who does not sign, and view where signed_commands is required',
    'needs_reason': '{request} needs a reason, for the record; nothing was done',
    'not_in_remote': '{request} is asked at a panel of a line in local, and the line is in '
    'remote; nothing was done; give control to the panels with local first',
    'not_in_local': '{request} moves the line, which is in local: only its panels may do that, '
    'and {who} ({known}) is at none; nothing was done; give control back at a panel with remote; '
    'without one, start the node anew with --control remote',
    'needs_panel': 'a line in local needs a panel that can move it: {words}',
    'no_panels': 'a virtual line has no panels',
    'no_panel_named': 'there is no panel in {file}; name one with: bt-orchestrator user panel '
    'address 192.168.3.20',
    'no_door_believed': 'this node believes no page and no OPC UA server who is at a panel; give '
    'them keys (bt-orchestrator user key NAME --door page), or start the node with '
    '--trust-local-doors, where the discovery range of ROS is this computer',
    'session_locked': 'this session is locked; unlock it with the password',
    'node_silent': 'the node of the cell is silent; nothing was sent to it',
    # the journal cannot be written
    'broken': '{what}; nothing is sent any more, what runs goes on to its end unless abort '
    'cancels it. Make room or mend the file, and start the orchestrator again: it takes over from '
    'the journal',
    'broken_asked': '{what}; nothing is sent any more, {count} asked to cancel without a record, '
    '{left} of them not ended. Make room or mend the file, and start the orchestrator again: it '
    'takes over from the journal',
    # who has signed it
    'signed_long': 'a signed request of {count} characters is too long',
    'signed_form': 'a signed request is JSON with {fields}; found {found}',
    'signed_otherwise': 'the signature is not that of the key {key} for this request: it was '
    'changed on the way',
    'signed_for_node': 'the request is signed for another node, {found}; this is {name}',
    'signed_for_journal': 'the request is signed for another journal, {found}; this is {name}',
    'signed_again': 'the key {key} has signed number {number}, and has used {last} already: a '
    'copy, or a request that was overtaken; give it again',
    'unknown_key': 'the request is signed with a key that the users file of this node does not '
    'have, {key}; add it: bt-orchestrator user key NAME --role ROLE --public KEY',
    'key_of_door': 'the key {key} is of {door}, and asks for its users alone, each known as '
    '{known}; found {found}',
    'signed_before_start': "the request is signed for another start of the node's computer; give "
    'it again',
    'signed_ahead': 'the request is signed for a moment {seconds} s ahead of the uptime of this '
    'node: somebody else has told it; look who publishes the status of this node',
    'signed_late': 'the request was signed {seconds} s ago; expected at most {most} s, since a '
    'late command is an attack; give it again',
    # what a request is made of
    'no_request': 'there is no request {found}; one of {requests}',
    'takes': '{request} takes {parameters}; found {found}',
    'takes_nothing': '{request} takes nothing; found {found}',
    'lacks': '{request} needs {parameter}: {meaning}',
    'not_of_kind': '{parameter} of {request} is {kind} ({meaning}); found {found}',
    'not_in_span': '{parameter} of {request} is a whole number from {low} to {high} ({meaning}); '
    'found {found}',
    'not_chosen': '{parameter} of {request} is one of {choices}; found {found}',
    'too_many_commands': 'too many commands: {who}, or all senders together, have filled the '
    'journal as fast as they may; nothing was done; give it again in {seconds} s (abort, stop, '
    'pause and answers to holds are always taken)',
    'too_many_characters': '{field} has {count} characters; expected at most {most}',
    'not_recorded': '{field} cannot be recorded: {words}; write it without; nothing was done',
    'unseen': 'it has {char} ({name}), which hides or turns what is read',
    'nothing_done': 'nothing was done',
    'no_arguments': 'expected the arguments as a mapping in JSON or YAML, as in {example}; found '
    '{found}',
    'wrong_arguments': 'expected the arguments as a mapping in JSON or YAML, as in {example}; '
    '{words}',
    'fewer_arguments': 'the arguments have {count} characters; expected at most {most}; give '
    'fewer at a time',
    'no_text': 'the arguments are not a valid text: {cause}',
    'long_yaml': 'arguments of more than {most} characters must be JSON',
    'long_fields': 'the {fields} have {count} characters; expected at most {most}',
    'no_fields': '{fields} are a mapping, {example}; found {found}',
    'wrong_results': 'results: {words}',
    'wrong_args': 'args: {words}',
    'say_what': 'say what to change: {parameters}',
    # which reason of the plant, which stop
    'no_reasons': 'this node knows no reasons, and not {code}; start it with --reasons FILE',
    'no_such_reason': 'there is no reason {code}; {words}',
    'plant_has': 'the plant has {names}',
    'empty_code': 'the code of the reason is empty; nothing was done',
    'reason_of_one': 'a reason of the plant is for one pause or hold: name it, --hold N',
    'stop_form': 'a stop has a name as in {history}:123; found {found}',
    'stop_elsewhere': 'the stop {name} is of another history than this journal, which is '
    '{history}',
    'no_such_stop': 'no stop of the line began with event {seq}; `report --json` and the page '
    'name the stops',
    'no_stop_names': 'this node keeps no journal, so a stop has no name that lasts; start it with '
    '--journal FILE',
    # the state of the cell, its pauses
    'refused_because': '{request} is refused: {words}',
    'not_in_state': 'the cell is {state}; {verb} is for {states}; possible now: {verbs}',
    'not_in_this_state': 'the cell is {state}; {verb} is for another state; possible now: {verbs}',
    'many_pauses': '{count} pauses stand already, and more are not kept; each of them keeps the '
    'cell from starting anything until it is released with resume',
    'not_paused': 'the cell is not paused; it is {state}',
    'not_paused_waits': 'the cell is not paused; it waits for answers to {named_holds}',
    'no_pause': 'there is no pause {hold}',
    'nothing_released': 'nothing was released',
    'no_pause_yours': 'no pause is yours',
    'pause_by_number': '{held}, which only its number releases: {command}',
    'pause_of_others': 'the person who paused resumes, or name the hold to release it for that '
    'person',
    'no_stop_wished': 'there is nothing to take back: no stop was asked for',
    'none_started': 'no job has started; hold the jobs of the queue instead',
    # local and remote, manual mode
    'control_already': 'the line is in {control} already',
    'in_manual': 'the cell is in manual mode; end it with production first',
    'manual_already': 'the cell is in manual mode already',
    'not_in_manual': 'the cell is not in manual mode',
    'no_manual_here': 'the cell is {state}; manual is for {states}, where nothing runs; stop it '
    'first',
    'items_on_belt': 'there are items on the belt: {belt}; take them off, each with remove-item',
    'manual_goal_runs': 'a goal of manual mode runs; wait for its end, or cancel it',
    'manual_goal_open': 'it is open how {task} at {component} ended; answer {held} first',
    'manual_goal_ends': '{task} at {component} is being cancelled already',
    'no_manual_goal': '{component} has no goal of manual mode',
    'no_goal': '{component} gets no goal: {words}',
    'cell_is': 'the cell is {state}',
    'one_manual_goal': '{task} at {component} runs, and manual mode has one goal at a time',
    'hold_open': '{held} is open',
    'hold_keeps_not': 'hold {hold} does not keep it',
    'kept': '{task} keeps it',
    'kept_in_doubt': 'it is in doubt; answer {held} first',
    'kept_by_hold': '{held} keeps it; name that hold: it stays',
    'kept_zone': '{task} keeps zone {zone}',
    'kept_zone_held': '{task} keeps zone {zone} (hold {hold})',
    'waits_for_service': 'waiting for {component}, which is out of service ({words})',
    'waits_for_value': 'waiting for {topic}; it is {value}',
    'waits_for_news': 'waiting for {topic}; nothing is published there',
    # components
    'no_component': 'there is no component {component}',
    'cell_has': 'the cell has {components}',
    'did_you_mean': 'did you mean `{name}`?',
    'component_gone': '{component} is not in the cell file any more',
    'out_already': '{component} is out of service already ({words})',
    'in_service': '{component} is in service; out of service now: {components}',
    'no_such_task': '{type} has no task {task}; {words}',
    'its_tasks': 'its tasks are {tasks}',
    'add_constant': 'add a constant to the goal of that type',
    # holds and items
    'hold_why': 'hold {hold} ({reason}, {message})',
    'hold_of': 'hold {hold} ({task}: {reason})',
    'hold_bare': 'hold {hold} ({reason})',
    'no_hold': 'there is no hold {hold}; holds now: {holds}',
    'takes_none': '{held} takes no answer; {command}',
    'takes_removal': '{held} takes no answer; take {item} off the belt and say so with '
    'remove-item {item}',
    'answers_are': '{held} can be answered with {replies}; found {found}',
    'answers_are_also': '{held} can be answered with {replies}; {words}; found {found}',
    'answers_of_others': '{held} has no answer for this role; {words}; found {found}',
    'may_answer': '{people} may: {replies}',
    'may_also_answer': '{people} may also: {replies}',
    'results_of_item': 'results are given with mark_done, of the task of an item; found {answer} '
    'of {task}',
    'no_results': 'hold {hold} is about no task that can have results; answer it without',
    'not_on_belt': '{item} is not on the belt; on it: {items}',
    # what stands on the belt
    'statement': '{verb} needs to know what stands on the belt: either every slot, as in 1=WO-1/3 '
    'and 2=empty, or the seq of the status of the belt as it stands',
    'slot_form': 'a slot is stated as N=ITEM or N=empty, found {found}',
    'slot_twice': 'slot {slot} is stated twice; state it once',
    'move_open': 'it is open whether the belt has moved; answer hold {hold} first: mark_done if '
    'it has, retry if it has not',
    'belt_changed': 'the belt has changed since the status with seq {seq}, at event {event} of '
    '{last}; the cell believes {belt}; look again',
    'slot_missing': 'slot {slots} is not stated; say of every slot from 1 to {last} what stands '
    'there; the cell believes {belt}',
    'no_slot': 'slot {slots} does not exist; say of every slot from 1 to {last} what stands '
    'there; the cell believes {belt}',
    'slot_other': 'slot {slot}: the cell believes {content}, not {stated}',
    'not_on_line': 'no such item is on the line; take it off and say empty',
    'belongs': '{item} belongs into slot {slot}: put it there, or take it off',
    'if_placed': 'if {task} did place it, answer hold {hold} with mark_done first',
    'not_believed': 'it is not on the belt for the cell; take it off and say empty',
    # jobs
    'no_job': 'there is no job {job}; jobs now: {jobs}',
    'not_listed': '{job} is no longer listed; the journal has its history',
    'not_for_job': '{job} is {job_state}; {method} is for jobs that are {job_states}',
    'job_ends': '{job} is {job_state} already and ends when its last item has left the line',
    'job_ends_but': '{job} is {job_state} already and ends when its last item has left the line; '
    'only {method} is left',
    'job_not_paused': '{job} is not paused, the whole cell is; resume the cell instead',
    'no_first_piece': '{job} waits for no approval of a first piece',
    'first_piece_here': '{item}, the first piece of {job}, has not left the line yet',
    'first_piece_lost': '{item}, the first piece of {job}, cannot be approved: it was not packed, '
    'but {left}; job another {job} makes another one, job stop {job} ends the order',
    'not_approver': '{job} waits for the approval of {item}, its first piece, by {roles}; your '
    'role is {role}',
    'no_recipe': '{job} was ordered by its script, so it cannot be made anew; stop it (job stop '
    '{job}), and give an order for the rest',
    'no_rest': '{job} has begun all of its items, so nothing is left to queue; nothing was done',
    'not_by_recipe': '{job} is no job by recipe',
    'no_rest_id': '{id} cannot be the id of the rest: {words}; give another one',
    'not_released': '{job} is not released: {words}',
    'unreleased': 'its script was generated and is not released for this cell; release-script '
    '{digest} (by an engineer) lets it start in its turn',
    'unavailable': '{job} is unavailable: {words}',
    'lacks_component': 'it needs {components}, which is out of service; in-service lets it start '
    'in its turn',
    'lacks_components': 'it needs {components}, which are out of service; in-service lets it '
    'start in its turn',
    # the queue
    'place': 'the position must be from 1 to {last}, not {position}',
    'has_started': '{job} has started; in the queue: {jobs}',
    'not_queued': '{job} is not there; in the queue: {jobs}',
    'queue_left': 'the queue has changed since: {jobs} left it; propose an order again',
    'queue_came': 'the queue has changed since: {jobs} came; propose an order again',
    'queue_both': 'the queue has changed since: {jobs} left it and {others} came; propose an '
    'order again',
    'queue_other': 'the queue has changed since: an order, a hold or a place in it is another '
    'one; propose an order again',
    'queue_names': 'jobs are {jobs}, each once, in the new order',
    'place_chosen': '{job} stays at place {place}, which a person chose; use move',
    'queue_same': 'the queue is in this order',
    # orders
    'fits': '{job} fits, but was not queued because of the others',
    'id_again': 'order {job} was given before; choose another id',
    'other_recipe': 'recipe {recipe} version {version} was another one before: it is {digest} '
    'now, and was {before}; give the recipe another version',
    'flag_differs': 'script {script} and script {other} share the flag {flag} but disagree on its '
    'capacity, its initial count or the sections of its tasks; make them agree or use two names',
    'stuck_together': 'script {script} shares flags with {others}, and where jobs of both follow '
    'each other the line can get stuck, although with each alone it cannot; use other flags, or '
    'wait until no job of {others} is left',
    'no_orders': 'name at least one order',
    'many_orders': '{count} orders are too many for one request, which is carried out as a whole; '
    'nothing was queued; give {most} or fewer at a time',
    'large_orders': 'the orders of this request have {count} bytes of text, and a request may '
    'have {most}; nothing was queued; give fewer at a time, or shorter ones',
    'no_order': 'each work order is a mapping, as an order file; found {found}',
    'a_moment': 'a date and time with its time zone',
    'a_real_moment': 'a day and a time that exist',
    'a_year': 'between 1970 and 2038',
    'its_numbers': 'look at its numbers',
    'add_zone': 'write {text}Z for UTC, or the offset: {text}+01:00',
    'add_time': 'write for instance {text}T06:00:00+01:00',
    'moment_form': 'write for instance 2026-05-18T06:00:00+02:00, or 2026-05-18T04:00:00Z',
    'refused_order': '{job} is refused with {count} findings: {words}',
    'refused_order_1': '{job} is refused with 1 finding: {words}',
    'findings_are': 'refused with {count} findings: {words}',
    'finding_is': 'refused with 1 finding: {words}',
    'findings': 'refused with {count} findings',
    'finding': 'refused with 1 finding',
    'reading_late': 'reading this took longer than {seconds} s and was given up; try the script '
    'with bt-orchestrator check, or give fewer orders at a time',
    'reading_busy': '{count} requests with orders wait to be read; give this one again when some '
    'of them are answered',
    'reading_failed': 'orders cannot be read now: {words}, twice; give this one again, and see '
    'whether the machine of the node has memory and processes left',
    'making_late': 'generating the scripts took longer than {seconds} s and was given up; try it '
    'with bt-orchestrator generate, or give an order with its script',
    'making_busy': '{count} requests wait for scripts of recipes; give this one again later',
    'making_failed': 'no script can be generated now: {words}; give this one again, and see '
    'whether the machine of the node has memory and processes left',
    # releases of scripts
    'other_cell': '{script} was generated for another cell file ({meant}) than the one that runs '
    'here ({digest}); generate it with that file, and release what comes of it',
    'released_already': '{script} is released for this cell already',
    'several_scripts': 'several scripts are called {script}; name the digest of one; jobs wait '
    'for {scripts}',
    'no_script_awaited': 'no job in the queue waits for {script}; name the digest of one; jobs '
    'wait for {scripts}',
}
"""Of requests that are refused."""

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
"""Of requests that are carried out."""
