def files(*a):
    return {}
