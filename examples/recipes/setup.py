from setuptools import find_packages, setup

package_name = 'recipes'

setup(
    name=package_name,
    version='0.1.0',
    description='The plants of the recipes, for obs_ros',
    maintainer='obs_ros maintainers',
    maintainer_email='maintainers@obs-ros.org',
    license='Apache-2.0',
    packages=find_packages(),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (f'share/{package_name}', ['package.xml']),
        (f'share/{package_name}/config', ['config/joint.yaml']),
    ],
    install_requires=['setuptools', 'numpy'],
    zip_safe=True,
)
