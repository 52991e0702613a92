#include "passivity.h"

#include "cohaptic_math.h"

Vector limited_force(Vector force, double max_force)
{
    const double size = hypot(force.x, force.y);
    return size > max_force ? times(max_force / size, force) : force;
}

Vector passive_force(const Passivity *passivity, double energy, Vector force, Vector moved)
{
    const Vector rendered = limited_force(force, passivity->max_force);
    const double left = energy - dot(rendered, moved), square = dot(moved, moved);
    if (!(passivity->controlled && left < 0.0 && square > 0.0)) return rendered;
    const double damping = fmin(-left * passivity->period / square, passivity->damping_limit);
    return limited_force(minus(rendered, times(damping / passivity->period, moved)),
                         passivity->max_force);
}
