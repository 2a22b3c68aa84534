"""Package definition for colcon (ament_python) and for pip."""

from pathlib import Path

import setuptools

NAME = 'bt_orchestrator'
SHARE = f'share/{NAME}'


def share_files(folder: str) -> tuple[str, list[str]]:
    """Install the files of one top-level folder under share/."""
    files = (path for path in Path(folder).glob('*') if path.is_file())
    return f'{SHARE}/{folder}', sorted(str(path) for path in files)


def develop_options() -> dict[str, dict[str, str]]:
    """Where `colcon build --symlink-install` puts programs, with setuptools before 80.

    Newer ones have no such option, and `pip install -e` fails on it when it stands in setup.cfg.
    """
    if int(setuptools.__version__.split('.')[0]) >= 80:
        return {}
    return {'develop': {'script_dir': f'$base/lib/{NAME}'}}


setuptools.setup(
    name=NAME,
    version='0.1.0',
    description='Behaviour trees of ROS 2 action clients for robotic cells along a conveyor',
    author='bt_orchestrator maintainers',
    author_email='maintainers@example.org',
    maintainer='bt_orchestrator maintainers',
    maintainer_email='maintainers@example.org',
    license='Apache-2.0',
    packages=setuptools.find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        share_files('config'),
        share_files('config/orders'),
        share_files('launch'),
        share_files('schemas'),
        share_files('trees'),
    ],
    options=develop_options(),
    zip_safe=True,
    python_requires='>=3.10',
    # ROS 2 packages are not named here: they come from a distribution or from its wheels, and
    # py_trees_ros exists only in the former. package.xml lists them all.
    install_requires=['argcomplete>=2', 'graphviz', 'py_trees>=2.2,<2.7', 'PyYAML', 'rich>=13.7'],
    extras_require={'test': ['hypothesis', 'jsonschema', 'pyte', 'pytest', 'pytest-timeout']},
    entry_points={
        'console_scripts': [
            'bt-orchestrator = bt_orchestrator.cli.main:main',
            # Names for `ros2 run bt_orchestrator ...` and for launch files.
            'tree_node = bt_orchestrator.cli.run:tree_node_main',
            'sim_cell = bt_orchestrator.cli.sim_cell:sim_cell_main',
        ],
    },
)
