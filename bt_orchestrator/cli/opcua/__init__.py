"""The verb `opcua`."""
