"""Springs between coordinates that rub, and that stops limit.

With the relative coordinate u, its rate v, and data of the scene for each of them,

    force    k (u - o) + d v, friction, and (u - limit) k_s + d_s v beyond a stop
    sliding  sgn(v) (f_d + f_s exp(-(|v| - v_0) / v_e) + f_v (|v| - v_0)); linear in v for |v| <= v_0
    sticking k_f (u - u_0) + d_f v, up to f_d + f_s; where v_0 is given, it slides always

DATA of each are the force of sliding, zero while it sticks; u_0; and how far u is beyond a stop. They change
once a step, as Exudyn's ObjectConnectorCoordinateSpringDamperExt has it.
"""

import numpy as np

from ..compiled import inlined
from .circle_contacts import NOW, START

DATA = 3
SLIDES, STUCK_AT, BEYOND = range(DATA)


@inlined
def _sliding(connector, rate):
    most, over = connector.dynamic + connector.static, np.abs(rate) - connector.zone
    if over <= 0.0 and connector.zone != 0.0:
        return most * rate / connector.zone
    share = np.exp(-over / connector.decay) if connector.decay != 0.0 else 1.0
    return np.sign(rate) * (connector.dynamic + connector.static * share + connector.viscosity * over)


@inlined
def _sticking(connector, stuck_at, way, rate):
    return connector.sticking_stiffness * (way - stuck_at) + connector.sticking_damping * rate


@inlined
def _settle_friction(connector, data, way, rate):
    """It breaks loose, slides on, or sticks where that begins with the last force of sliding."""
    now, start = data[NOW, connector.place :], data[START, connector.place :]
    sliding = _sliding(connector, rate)
    if now[SLIDES] == 0.0:
        sticking = _sticking(connector, now[STUCK_AT], way, rate)
        if np.abs(sticking) > connector.dynamic + connector.static:
            now[SLIDES] = sliding
    elif rate * now[SLIDES] >= 0.0:
        now[SLIDES], now[STUCK_AT] = sliding, way
    elif start[SLIDES] == 0.0:
        now[SLIDES], now[STUCK_AT] = 0.0, start[STUCK_AT]
    else:
        stretch = (start[SLIDES] - connector.sticking_damping * rate) / connector.sticking_stiffness
        now[SLIDES], now[STUCK_AT] = 0.0, way - stretch


@inlined
def _settle_stops(connector, data, way):
    below, above = min(way - connector.stops[0], 0.0), max(way - connector.stops[1], 0.0)
    before = data[NOW, connector.place + BEYOND]
    from_below = before < 0.0 or (before == 0.0 and above == 0.0)
    data[NOW, connector.place + BEYOND] = below if from_below else above


@inlined
def _friction(connector, data, way, rate):
    if connector.zone != 0.0:
        return _sliding(connector, rate)
    if connector.dynamic == 0.0 and connector.static == 0.0:
        return 0.0
    slides = data[NOW, connector.place + SLIDES]
    if slides == 0.0:
        return _sticking(connector, data[NOW, connector.place + STUCK_AT], way, rate)
    return np.sign(slides) * np.abs(_sliding(connector, rate))


@inlined
def _force_of_stops(connector, data, way, rate):
    beyond = data[NOW, connector.place + BEYOND]
    if beyond == 0.0:
        return 0.0
    limit = connector.stops[0] if beyond < 0.0 else connector.stops[1]
    return connector.stop_stiffness * (way - limit) + connector.stop_damping * rate


@inlined
def force_of_rubbing(connector, data, settles):
    """Of friction and stops, from its stretch and rate.   data: see `Contacts`.   settles: before that."""
    way, rate = connector.stretch[0], connector.rate[0]
    if settles and connector.place >= 0:
        _settle_friction(connector, data, way, rate)
        if connector.has_stops:
            _settle_stops(connector, data, way)
        else:
            data[NOW, connector.place + BEYOND] = 0.0
    force = _friction(connector, data, way, rate)
    return force + _force_of_stops(connector, data, way, rate) if connector.has_stops else force
