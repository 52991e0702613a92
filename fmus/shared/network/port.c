#include "port.h"

#include "cohaptic_math.h"

double port_energy(const Port *port, Planar place)
{
    if (!port->open) return port->energy;
    return port->energy - port->effort.x * (place.x - port->place.x)
           - port->effort.y * (place.y - port->place.y)
           - port->effort.theta * (place.theta - port->place.theta);
}

Port port_next(const Port *port, Planar place, Planar effort, bool open, double reserve)
{
    double energy = port_energy(port, place);
    if (reserve > 0.0) energy = fmin(energy, reserve);
    return (Port){effort, place, energy, open};
}
