"""The inspection server: what tree watchers attach to (py-trees-tree-watcher and its like).

    server.py              the services, and the turns that publish
    snapshot_streams.py    snapshots of the tree, one topic a watcher
    blackboard_streams.py  the blackboard as text, one topic a watcher
    snapshot_source.py     the contents of snapshots, and how long ticks take
    tree_messages.py       behaviours to messages
    blackboard_view.py     reading the blackboard, and what was done on it
    attachment.py          whether a stream still has a watcher
    topic_names.py         the topics of streams
    start.py               the server of py_trees_ros instead, where that is asked for
    start.py               starts the one or the other, if what it needs is installed

Everything runs in the executor's thread, between settles and never inside one.
"""
