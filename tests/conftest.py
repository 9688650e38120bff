import signal

from hypothesis import HealthCheck, settings

# A loaded machine makes slow examples; a property says what is true, not how fast it is found out.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

# A runner that was started in the background ignores SIGINT, and the programs under test would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
