#include "passivity.h"

#include "cohaptic_math.h"

Vector limited_force(Vector force, double max_force)
{
    const double size = hypot(force.x, force.y);
    return size > max_force ? times(max_force / size, force) : force;
}

Vector passive_force(const Passivity *passivity, double energy, Vector force, Vector velocity,
                     double *energy_after)
{
    Vector rendered = limited_force(force, passivity->max_force);
    const double flow = passivity->period * dot(velocity, velocity);
    const double left = energy - passivity->period * dot(rendered, velocity);
    if (passivity->controlled && left < 0.0 && flow > 0.0) {
        const double damping = fmin(-left / flow, passivity->damping_limit);
        rendered = limited_force(minus(rendered, times(damping, velocity)), passivity->max_force);
    }
    *energy_after = energy - passivity->period * dot(rendered, velocity);
    if (passivity->reserve > 0.0) *energy_after = fmin(*energy_after, passivity->reserve);
    return rendered;
}
