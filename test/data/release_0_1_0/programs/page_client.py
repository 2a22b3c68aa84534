"""An MES of 0.1.0 at the operator page: logs in, queues two orders, reads jobs and an item.

PAGE_PASSWORD=… python page_client.py http://HOST:8080 USER SCRIPT
"""

from __future__ import annotations

import json
import os
import sys
from http.cookiejar import CookieJar
from typing import Any
from urllib.request import HTTPCookieProcessor, Request, build_opener

PAGE, USER, SCRIPT = sys.argv[1:]
OPENER = build_opener(HTTPCookieProcessor(CookieJar()))


def ask(path: str, body: object = None) -> Any:
    """Get what is at a path, or post to it."""
    data = None if body is None else json.dumps(body).encode()
    headers = {'Origin': PAGE, 'Content-Type': 'application/json'}
    with OPENER.open(Request(PAGE + path, data, headers), timeout=60) as answer:
        return json.load(answer)


ask('/api/login', {'name': USER, 'password': os.environ['PAGE_PASSWORD']})
print('role', ask('/api/me')['role'])
print('cell', ask('/api/cell')['status']['cell'])
for order, path in (('API-1', '/api/queue/add'), ('API-2', '/api/requests/queue.add')):
    orders = [{'order': order, 'script': SCRIPT, 'quantity': 1}]
    ticket = order.encode().hex().rjust(16, '0')
    print(order, ask(path, {'orders': orders, 'ticket': ticket})['accepted'])
command = {'command': 'cancel', 'job': 'API-2', 'reason': 'no longer wanted', 'ticket': '0' * 16}
print('cancel', ask('/api/queue/command', command)['accepted'])
jobs = {job['id']: job for job in ask('/api/jobs')['jobs']}
print('WO-2001', jobs['WO-2001']['status'], jobs['WO-2001']['counts']['packed'])
item = ask('/api/items/WO-2001%2F1')
print(item['item'], item['how'], [task['task'] for task in item['tasks']])
print('events', len(ask('/api/events?after=0&most=5')['records']))
