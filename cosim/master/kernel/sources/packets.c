/* Packets on their way: sampled, delayed, lost, doubled, delivered and held.

   What becomes of each packet (its delay in ticks, or that it is lost) was drawn before, by
   cosim/master/channels/fates.py; here it is only carried out. */

#include "kernel.h"

static int64_t fate(const Bundle *bundle)
{
    return bundle->fates ? bundle->fates[bundle->sequence - bundle->fate_first] : bundle->delay;
}

static bool enqueue(Bundle *bundle, const Cell *cells, int64_t tick, int64_t delay, bool copy)
{
    if (bundle->in_flight == bundle->capacity)
        return false;
    int64_t slot = bundle->in_flight++;
    bundle->arrival[slot] = tick + delay;
    bundle->flight_sequence[slot] = bundle->sequence;
    bundle->flight_sampled[slot] = copy ? -1 : tick;
    if (!copy) {
        Cell *payload = bundle->payload + slot * bundle->width;
        for (int64_t i = 0; i < bundle->width; i++)
            payload[i] = cells[bundle->sources[i]];
    }
    if (tick + delay < bundle->next_arrival)
        bundle->next_arrival = tick + delay;
    return true;
}

static void take(Bundle *bundle, int64_t slot)
{
    const Cell *payload = bundle->payload + slot * bundle->width;
    for (int64_t i = 0; i < bundle->width; i++)
        bundle->held[i] = payload[i];
    bundle->held_sequence->integer = bundle->flight_sequence[slot];
    bundle->sampled = bundle->flight_sampled[slot];
    bundle->delivered++;
}

static void move(Bundle *bundle, int64_t to, int64_t from)
{
    bundle->arrival[to] = bundle->arrival[from];
    bundle->flight_sequence[to] = bundle->flight_sequence[from];
    bundle->flight_sampled[to] = bundle->flight_sampled[from];
    Cell *target = bundle->payload + to * bundle->width;
    const Cell *source = bundle->payload + from * bundle->width;
    for (int64_t i = 0; i < bundle->width; i++)
        target[i] = source[i];
}

/* Takes the newest of the packets that are due; older ones are late, second copies duplicates. */
static void arrive(Bundle *bundle, int64_t tick)
{
    int64_t newest = -1;
    for (int64_t i = 0; i < bundle->in_flight; i++) {
        bool packet = bundle->arrival[i] <= tick && bundle->flight_sampled[i] >= 0;
        if (packet && bundle->flight_sequence[i] > bundle->held_sequence->integer
            && (newest < 0 || bundle->flight_sequence[i] > bundle->flight_sequence[newest]))
            newest = i;
    }
    if (newest >= 0)
        take(bundle, newest);

    int64_t kept = 0;
    bundle->next_arrival = INT64_MAX;
    for (int64_t i = 0; i < bundle->in_flight; i++) {
        if (bundle->arrival[i] > tick) {
            if (bundle->arrival[i] < bundle->next_arrival)
                bundle->next_arrival = bundle->arrival[i];
            if (kept != i)
                move(bundle, kept, i);
            kept++;
        } else if (bundle->flight_sampled[i] < 0) {
            bundle->duplicate++;
        } else if (i != newest) {
            bundle->late++;
        }
    }
    bundle->in_flight = kept;
}

/* The start of a tick: what is due arrives, and the age of what is held is told. */
void deliver(Bundle *bundle, int64_t tick)
{
    bundle->immediate = tick % bundle->period == 0 && fate(bundle) == 0;
    if (bundle->immediate) {
        bundle->held_sequence->integer = bundle->sequence;
        bundle->sampled = tick;
    }
    if (tick >= bundle->next_arrival)
        arrive(bundle, tick);
    bundle->age->integer = tick - bundle->sampled;
}

/* Samples and sends the packet of this tick; false if there is no room for it. */
bool send_packet(Bundle *bundle, const Cell *cells, int64_t tick)
{
    int64_t delay = fate(bundle);
    int64_t copy = bundle->fates ? bundle->copies[bundle->sequence - bundle->fate_first] : -1;
    bool room = true;

    bundle->sent++;
    if (delay < 0)
        bundle->lost++;
    else if (delay == 0)
        bundle->delivered++;
    else
        room = enqueue(bundle, cells, tick, delay, false);

    if (copy == 0)
        bundle->duplicate++;
    else if (copy > 0)
        room = room && enqueue(bundle, cells, tick, copy, true);

    bundle->sequence++;
    return room;
}
