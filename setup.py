import sys
from glob import glob

from setuptools import find_packages, setup

package_name = 'obs_ros'

data_files = [
    ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
    (f'share/{package_name}', ['package.xml']),
    (f'share/{package_name}/config', sorted(glob('config/*.yaml'))),
    (f'share/{package_name}/layouts', sorted(glob('layouts/*'))),
]
# `ros2 run` looks in lib/obs_ros. colcon puts the executables there because of setup.cfg; pip
# ignores that and fills bin/, so what pip builds carries launchers that lead from one to the other.
if {'bdist_wheel', 'sdist'} & set(sys.argv):
    data_files.append((f'lib/{package_name}', sorted(glob('tools/launchers/*'))))

setup(
    name=package_name,
    version='0.1.0',
    description='Live estimates of the hidden states and drifting parameters of a plant',
    maintainer='obs_ros maintainers',
    maintainer_email='maintainers@obs-ros.org',
    license='Apache-2.0',
    packages=find_packages(include=['obs_ros', 'obs_ros.*', 'plant_sim', 'plant_sim.*']),
    package_data={
        'obs_ros.cli': ['templates/*.txt'],
        'obs_ros.pages': ['*.css', '*.html', '*.js'],
    },
    data_files=data_files,
    python_requires='>=3.11',
    install_requires=['numpy>=1.26', 'pyyaml', 'scipy>=1.11'],
    extras_require={
        'fast': ['numba'],
        'plot': ['matplotlib'],
        'design': ['cvxpy', 'clarabel'],
        'fleet': ['distributed', 'pyarrow'],
        'peers': ['casadi', 'cma', 'do-mpc', 'filterpy', 'pygmo', 'pymoo'],
        'replay': ['matplotlib', 'rosbags'],
        'test': ['pytest'],
    },
    zip_safe=True,
    entry_points={
        'console_scripts': [
            'check_model = obs_ros.cli.start:check_model',
            'estimator = obs_ros.cli.start:estimator',
            'fleet = obs_ros.cli.start:fleet',
            'init = obs_ros.cli.start:init',
            'replay = obs_ros.cli.start:replay',
            'simulator = obs_ros.cli.start:simulator',
            'view = obs_ros.cli.start:view',
        ],
    },
)
