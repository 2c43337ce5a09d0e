"""How long tests wait for what is to come."""

#: Before a test gives up on another process or thread: many times what any takes on a machine of its own. [s]
PATIENCE = 300.0
