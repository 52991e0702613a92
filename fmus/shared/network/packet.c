#include "packet.h"

#include "cohaptic_math.h"

static double size_of(Vector v) { return hypot(v.x, v.y); }

static bool differs(const Deadband *deadband, const Packet *held, const Packet *now, double felt,
                    double age)
{
    for (int f = 0; f < 2; f++) {
        const double shown = fmax(size_of(held->force[f]), deadband->force);
        if (size_of(minus(now->force[f], held->force[f])) > deadband->fraction * shown) return true;
    }
    const double least = deadband->fraction * fmax(felt, deadband->force);
    for (int m = 0; m < MOTIONS; m++) {
        const Motion *old = &held->motion[m], *new = &now->motion[m];
        const double ahead = deadband->predicted ? age : 0.0;
        const Vector taken = plus(old->position, times(ahead, old->velocity));
        const Vector change = plus(times(deadband->stiffness[m], minus(new->position, taken)),
                                   times(deadband->damping[m], minus(new->velocity, old->velocity)));
        if (size_of(change) > (m == MOTION_BOX_ANGLE ? least * deadband->arm : least)) return true;
    }
    return false;
}

SentPacket packet_send(const Deadband *deadband, const SentPacket *before, const Packet *now,
                       double felt, int64_t tick)
{
    SentPacket sent = *before;
    if (!(deadband->fraction > 0.0)) {
        sent.packet = *now;
        sent.tick = tick;
        if (tick % deadband->samples == 0) sent.due = ++sent.sent;
        return sent;
    }
    if (tick % deadband->samples != 0) return sent;
    const int64_t age = tick - before->tick;
    sent.due++;
    if (before->due > 0 && age < deadband->longest * deadband->samples
        && !differs(deadband, &before->packet, now, felt, (double)age * deadband->period))
        return sent;
    sent.packet = *now;
    sent.tick = tick;
    sent.sent++;
    return sent;
}
