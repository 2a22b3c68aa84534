"""The verb `opcua`, and what it is made of."""
