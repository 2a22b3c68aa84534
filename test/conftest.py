"""Settings of every test."""

from hypothesis import settings

pytest_plugins = ['ros_domain']

# The same examples in every run: a red gate means that the change is wrong. No deadline, because
# a busy machine is no bug.
settings.register_profile('gate', derandomize=True, deadline=None)
settings.load_profile('gate')
