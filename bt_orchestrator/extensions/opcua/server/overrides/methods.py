"""Calls of methods: a method says by its exception what was wrong."""

from __future__ import annotations

import logging
from typing import Any

from asyncua import ua
from asyncua.server.address_space import MethodService

log = logging.getLogger(__name__)


class Methods(MethodService):
    """asyncua answers every exception with BadUnexpectedError."""

    async def _run_method(self, func: Any, parent: ua.NodeId, *args: Any) -> Any:
        try:
            return await super()._run_method(func, parent, *args)
        except ua.UaStatusCodeError as error:
            return ua.StatusCode(error.code)
        except Exception:
            log.exception('defect: a method failed')
            return ua.StatusCode(ua.StatusCodes.BadInternalError)
