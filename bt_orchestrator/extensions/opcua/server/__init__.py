"""The OPC UA server of one cell, behind the door; the only room with asyncua."""
