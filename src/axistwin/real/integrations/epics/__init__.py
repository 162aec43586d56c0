"""EPICS: axes as motor records, pins and registers as records, by Channel Access and PV Access.

`MotorRecord` and `PointRecord` hold the fields and process writes; `channel_access` (caproto) and `pv_access` (p4p)
serve them.
"""
