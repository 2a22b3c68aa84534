"""The OPC UA server, the words of MES and PackML, and its verb."""
