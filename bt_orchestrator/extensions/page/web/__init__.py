"""The operator page: a cell in the browser, behind `ports.CellLink`, without ROS or the engine."""
