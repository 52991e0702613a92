#include "packet.h"

#include "cohaptic_math.h"

static double size_of(Vector v) { return hypot(v.x, v.y); }

static bool felt(Vector held, Vector now, double fraction, double least)
{
    return size_of(minus(now, held)) > fmax(fraction * size_of(held), least);
}

static bool differs(const Deadband *deadband, const Packet *held, const Packet *now, double age)
{
    for (int f = 0; f < 2; f++)
        if (felt(held->force[f], now->force[f], deadband->fraction, deadband->force)) return true;
    if (deadband->forces_only) return false;
    for (int m = 0; m < MOTIONS; m++) {
        const bool turning = m == MOTION_BOX_ANGLE;
        const Motion *old = &held->motion[m], *new = &now->motion[m];
        if (felt(old->velocity, new->velocity, deadband->fraction,
                 turning ? deadband->rate : deadband->velocity))
            return true;
        const double ahead = deadband->predicted ? age : 0.0;
        const Vector taken = plus(old->position, times(ahead, old->velocity));
        if (size_of(minus(new->position, taken)) > (turning ? deadband->angle : deadband->position))
            return true;
    }
    return false;
}

SentPacket packet_send(const Deadband *deadband, const SentPacket *before, const Packet *now,
                       int64_t tick)
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
        && !differs(deadband, &before->packet, now, (double)age * deadband->period))
        return sent;
    sent.packet = *now;
    sent.tick = tick;
    sent.sent++;
    return sent;
}
