#include "wave.h"

#include "cohaptic_math.h"

WavePort wave_receive(const WavePort *before, const double integral[2], int64_t source_tick,
                      bool counts, double period)
{
    if (!counts) return (WavePort){0};
    WavePort port = *before;
    const Vector received = {integral[0], integral[1]};
    const bool usable = source_tick >= 0 && isfinite(received.x) && isfinite(received.y);
    if (usable && !port.heard)
        port = (WavePort){.consumed = received,
                          .consumed_tick = source_tick,
                          .source_tick = source_tick,
                          .heard = 1};
    else if (usable && source_tick > port.source_tick) {
        const double span = (double)(source_tick - port.consumed_tick) * period;
        port.wave = times(1.0 / span, minus(received, port.consumed));
        port.source_tick = source_tick;
    }
    return port;
}

WavePort wave_consume(const WavePort *port, double period)
{
    WavePort next = *port;
    if (next.consumed_tick < next.source_tick) {
        next.consumed = plus(port->consumed, times(period, port->wave));
        next.consumed_tick++;
    }
    if (next.consumed_tick >= next.source_tick) next.wave = (Vector){0.0, 0.0};
    return next;
}
