"""The example interfaces, and some more, without ROS 2 (port `ActionTypes`)."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType

BOOL = FieldType('bool', 'bool')
UINT8 = FieldType('int', 'uint8', 0, 255)
INT32 = FieldType('int', 'int32', -(2**31), 2**31 - 1)
FLOAT32 = FieldType('float', 'float32')
FLOAT64 = FieldType('float', 'float64')
STRING = FieldType('str', 'string')

POINT = MessageType('geometry_msgs/msg/Point', {'x': FLOAT64, 'y': FLOAT64, 'z': FLOAT64})
POSE = MessageType(
    'test_interfaces/msg/Pose',
    {'frame': STRING, 'position': FieldType('message', POINT.name, message=POINT)},
)
POSE_FIELD = FieldType('message', POSE.name, message=POSE)

PACKAGE = 'bt_orchestrator_interfaces/action/'


def action(
    name: str,
    constants: tuple[str, ...],
    goal: Mapping[str, FieldType],
    result: Mapping[str, FieldType],
) -> ActionType:
    """Describe an action type; its constants count from 0, and it has a task field if any."""
    task = {'task': UINT8} if constants else {}
    return ActionType(
        name,
        MessageType(f'{name}_Goal', {**task, **goal}),
        MessageType(f'{name}_Result', dict(result)),
        {constant: number for number, constant in enumerate(constants)},
    )


def array(of: FieldType, length: int | None = None, longest: int | None = None) -> FieldType:
    """Describe an array of a type."""
    size = str(length) if length else f'<={longest}' if longest else ''
    return FieldType(
        of.kind,
        f'{of.ros_name}[{size}]',
        of.minimum,
        of.maximum,
        is_array=True,
        array_length=length,
        array_maximum=longest,
        message=of.message,
    )


ACTIONS = (
    action(
        PACKAGE + 'UnpackingArm',
        ('PREPARE', 'PICK_FROM_CASE', 'PLACE_AT_CONVEYOR'),
        {'other_var_1': STRING, 'other_var_2': FLOAT64},
        {'task_result': BOOL},
    ),
    action(
        PACKAGE + 'Component',
        ('PREPARE', 'TASK_A', 'TASK_B', 'TASK_C'),
        {'special_argument_1': STRING, 'special_argument_2': FLOAT64},
        {'task_result': BOOL, 'item_present': BOOL, 'measurement': FLOAT64},
    ),
    action(
        PACKAGE + 'PackingArm',
        ('PREPARE', 'PICK_AND_PACK'),
        {'other_var_1': STRING},
        {'task_result': BOOL},
    ),
    action(PACKAGE + 'Reader', ('READ',), {}, {'task_result': BOOL, 'serial': STRING}),
    action(PACKAGE + 'Conveyor', ('HOME', 'MOVE_ONE_INDEX'), {}, {'task_result': BOOL}),
    action('plain_interfaces/action/Index', (), {}, {}),
    action(
        'test_interfaces/action/Rich',
        ('RUN', 'STOP'),
        {
            'flag': BOOL,
            'small': UINT8,
            'count': INT32,
            'ratio': FLOAT32,
            'name': STRING,
            'code': FieldType('str', 'string<=3', string_maximum=3),
            'octet': FieldType('bytes', 'byte'),
            'pose': POSE_FIELD,
            'point': FieldType('message', POINT.name, message=POINT),
            'names': array(STRING),
            'triple': array(FLOAT64, length=3),
            'few': array(UINT8, longest=2),
            'poses': array(POSE_FIELD),
        },
        {
            'task_result': BOOL,
            'ok': BOOL,
            'code': STRING,
            'count': INT32,
            'value': FLOAT64,
            'pose': POSE_FIELD,
            'triple': array(FLOAT64, length=3),
            'pair': array(FLOAT64, length=2),
        },
    ),
    action(
        'nav_interfaces/action/DriveTo',
        (),
        {'place': STRING, 'speed': FLOAT64},
        {'reached': BOOL, 'distance': FLOAT64},
    ),
)

MESSAGES: Mapping[str, Mapping[str, str]] = {
    'std_msgs/msg/String': {'data': 'string'},
    'std_msgs/msg/Bool': {'data': 'boolean'},
    'std_msgs/msg/UInt8': {'data': 'uint8'},
    'diagnostic_msgs/msg/KeyValue': {'key': 'string', 'value': 'string'},
    'std_msgs/msg/Header': {'stamp': 'builtin_interfaces/Time', 'frame_id': 'string'},
}


class FakeActionTypes:
    """Knows a fixed set of types, less the actions of one package if told so."""

    def __init__(self, without: str = '') -> None:
        self._actions = {
            kind.name: kind for kind in ACTIONS if kind.name.split('/', maxsplit=1)[0] != without
        }

    def action(self, name: str) -> ActionType:
        if name not in self._actions:
            raise _unknown(name, [*self._actions])
        return self._actions[name]

    def message_field(self, type_name: str, field: str) -> str:
        if type_name not in MESSAGES:
            raise _unknown(type_name, [*MESSAGES])
        if field not in MESSAGES[type_name]:
            what = f'{type_name} has no field `{field}`'
            raise UnknownActionType(type_name, what, f'it has {", ".join(MESSAGES[type_name])}')
        return MESSAGES[type_name][field]


def _unknown(name: str, known: list[str]) -> UnknownActionType:
    package = name.split('/', maxsplit=1)[0]
    if any(known_name.startswith(f'{package}/') for known_name in known):
        return UnknownActionType(name, f'{package} has no type {name}', 'check its spelling')
    what = f'the package {package} is not installed'
    return UnknownActionType(name, what, f'install {package} and source its workspace')
