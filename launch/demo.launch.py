"""A simulated cell in two processes and the tree node that runs it.

    ros2 launch bt_orchestrator demo.launch.py --show-args
    ros2 launch bt_orchestrator demo.launch.py speed:=4.0
    ros2 launch bt_orchestrator demo.launch.py page:=true opcua:=true
    ros2 run bt_orchestrator bt-orchestrator submit ORDER

ORDER is a work order (YAML); the tree node waits for one.
"""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from bt_orchestrator.cli.bootstrap import installed_types, load_cell
from launch import LaunchContext, LaunchDescription

PACKAGE = 'bt_orchestrator'


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments; the processes follow when their values are known."""
    share = Path(get_package_share_directory(PACKAGE))
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'cell',
                default_value=str(share / 'config' / 'reference_cell.yaml'),
                description='Cell file (YAML): the belt and the components; all are simulated.',
            ),
            DeclareLaunchArgument(
                'trees',
                default_value=str(share / 'trees'),
                description='Folder in which work orders find their scripts by name.',
            ),
            DeclareLaunchArgument(
                'speed',
                default_value='1.0',
                description='All simulated seconds are divided by this.',
            ),
            DeclareLaunchArgument(
                'tick_rate_hz',
                default_value='10.0',
                description='Heartbeat of the tree in Hz; news wake it at once, whatever it is.',
            ),
            DeclareLaunchArgument(
                'namespace',
                default_value='',
                description='ROS namespace of the tree node and of relative names in the cell '
                'file. Absolute names stay as they are: two cells need different ones.',
            ),
            DeclareLaunchArgument(
                'page',
                default_value='false',
                choices=['true', 'false'],
                description='Serve the operator page on this computer; whoever sits here may give '
                'every command.',
            ),
            DeclareLaunchArgument(
                'page_port', default_value='8080', description='Port of the operator page.'
            ),
            DeclareLaunchArgument(
                'shifts',
                default_value='',
                description='File of shifts (YAML): the page shows OEE and losses of the shift '
                'that runs.',
            ),
            DeclareLaunchArgument(
                'opcua',
                default_value='false',
                choices=['true', 'false'],
                description='Serve OPC UA clients on this computer, without encryption; the users '
                'are those of bt-orchestrator user.',
            ),
            DeclareLaunchArgument(
                'opcua_port', default_value='4840', description='Port of the OPC UA server.'
            ),
            OpaqueFunction(function=_processes),
        ]
    )


def _processes(context: LaunchContext) -> list[Node]:
    """Divide the components of the cell file among two simulators.

    :raises Refused: the cell file, with every mistake in it
    """
    values = {
        name: LaunchConfiguration(name).perform(context)
        for name in (
            'cell',
            'trees',
            'speed',
            'tick_rate_hz',
            'namespace',
            'page',
            'page_port',
            'shifts',
            'opcua',
            'opcua_port',
        )
    }
    names = list(load_cell(Path(values['cell']), installed_types()).components)
    middle = len(names) // 2
    first, second = names[:middle], names[middle:]
    return [
        _simulator('sim_cell_1', first, values),
        _simulator('sim_cell_2', second, values),
        _tree_node(values),
        *([_page(values)] if values['page'] == 'true' else []),
        *([_opcua(values)] if values['opcua'] == 'true' else []),
    ]


def _simulator(name: str, components: list[str], values: dict[str, str]) -> Node:
    namespace = ['--namespace', values['namespace']] if values['namespace'] else []
    return Node(
        package=PACKAGE,
        executable='sim_cell',
        name=name,
        arguments=[
            '--cell',
            values['cell'],
            '--speed',
            values['speed'],
            '--only',
            ','.join(components),
            *namespace,
        ],
        output='screen',
    )


def _tree_node(values: dict[str, str]) -> Node:
    return Node(
        package=PACKAGE,
        executable='tree_node',
        namespace=values['namespace'],
        parameters=[
            str(Path(get_package_share_directory(PACKAGE)) / 'config' / 'tree_node.yaml'),
            {
                'cell': values['cell'],
                'trees': [values['trees']],
                'tick_rate_hz': float(values['tick_rate_hz']),
                'trust_local_doors': 'true' in (values['page'], values['opcua']),
            },
        ],
        output='screen',
    )


def _page(values: dict[str, str]) -> Node:
    account = ['--shifts', values['shifts'], '--cell', values['cell']] if values['shifts'] else []
    return _server('page', values['page_port'], ['--trust-this-computer', *account], values)


def _opcua(values: dict[str, str]) -> Node:
    return _server('opcua', values['opcua_port'], ['--insecure'], values)


def _server(verb: str, port: str, options: list[str], values: dict[str, str]) -> Node:
    namespace = values['namespace'].strip('/')
    node = f'/{namespace}/bt_orchestrator' if namespace else '/bt_orchestrator'
    return Node(
        package=PACKAGE,
        executable='bt-orchestrator',
        name=verb,
        arguments=[verb, '--node', node, '--port', port, *options],
        output='screen',
    )
