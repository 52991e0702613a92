/* Saving and restoring an instance. A snapshot is one block without pointers, so that serialising
   it is copying it; it says which build of which model it belongs to and carries a checksum. It has
   room for every row of a model's table, but holds, and serialises, those that are in use. The stop
   time is no part of it: a run that is continued has an end of its own. */
#include "instance.h"

typedef struct {
    char magic[8];
    uint64_t format, digest[2], size, checksum;
    Clock clock;
    Cell cells[]; /* the variables, then the model's State */
} Snapshot;

static const char magic[8] = {'C', 'O', 'H', 'A', 'P', 'T', 'I', 'C'};
enum { FORMAT = 2 };

static size_t size_with(size_t state_bytes)
{
    return sizeof(Snapshot) + 8 * (size_t)model_slots + ((state_bytes + 7) & ~(size_t)7);
}

/* What a snapshot takes in memory, whatever it holds. */
static size_t room(void) { return size_with(model_state_size); }

static State *state_of(const Snapshot *s) { return (State *)&s->cells[model_slots]; }

/* The bytes that a snapshot holds by what its state says; 0 where that cannot be. */
static size_t size_of(const Snapshot *s)
{
    const size_t used = model_state_used(state_of(s));
    return used <= model_state_size ? size_with(used) : 0;
}

/* FNV-1a over the words behind the header. */
static uint64_t checksum_of(const Snapshot *s)
{
    uint64_t hash = 0xcbf29ce484222325u;
    const char *begin = (const char *)&s->clock;
    for (const char *p = begin; p < (const char *)s + s->size; p += 8) {
        uint64_t word;
        memcpy(&word, p, 8);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    return hash;
}

static Status check_snapshot(Instance *i, const char *function, const Snapshot *s)
{
    if (s == NULL)
        return instance_complain(i, ERROR, "%s: there is no state (a null pointer).", function);
    if (memcmp(s->magic, magic, sizeof magic) != 0 || s->format != FORMAT ||
        memcmp(s->digest, model_digest, sizeof s->digest) != 0 || s->size != size_of(s))
        return instance_complain(i, ERROR, "%s: the state is not one of this build of '%s'.",
                                 function, model_name);
    return OK;
}

Status snapshot_get(Instance *i, const char *function, void **snapshot)
{
    const Status status = instance_expect(i, function, ~(uint32_t)PHASE_DEAD);
    if (status != OK)
        return status;
    if (snapshot == NULL)
        return instance_complain(i, ERROR, "%s: there is no place for the state.", function);
    Snapshot *s = *snapshot;
    if (s == NULL)
        s = platform_allocate(room());
    else if (check_snapshot(i, function, s) != OK)
        return ERROR;
    if (s == NULL)
        return instance_complain(i, ERROR, "%s: memory has run out.", function);
    /* With the outputs up to date, equal states are equal bytes. */
    if (i->clock.phase == PHASE_STEP && i->is_outdated)
        instance_evaluate(i);
    memcpy(s->magic, magic, sizeof magic);
    s->format = FORMAT;
    memcpy(s->digest, model_digest, sizeof s->digest);
    s->clock = i->clock;
    memcpy(s->cells, i->cells, 8 * (size_t)model_slots);
    memcpy(state_of(s), i->state, model_state_used(i->state));
    s->size = size_of(s);
    *snapshot = s;
    return OK;
}

Status snapshot_set(Instance *i, const char *function, const void *snapshot)
{
    Snapshot *s = (Snapshot *)snapshot;
    Status status = instance_expect(i, function, ~(uint32_t)PHASE_DEAD);
    if (status == OK)
        status = check_snapshot(i, function, s);
    if (status != OK)
        return status;
    i->clock = s->clock;
    memcpy(i->cells, s->cells, 8 * (size_t)model_slots);
    memcpy(i->state, state_of(s), model_state_used(state_of(s)));
    i->is_outdated = true;
    instance_clear_work(i);
    return OK;
}

Status snapshot_free(Instance *i, const char *function, void **snapshot)
{
    if (snapshot == NULL || *snapshot == NULL)
        return OK;
    const Status status = check_snapshot(i, function, *snapshot);
    if (status == OK) {
        memset(*snapshot, 0, sizeof magic);
        platform_free(*snapshot, room());
        *snapshot = NULL;
    }
    return status;
}

Status snapshot_size(Instance *i, const char *function, const void *snapshot, size_t *size)
{
    const Status status = check_snapshot(i, function, snapshot);
    if (status == OK && size == NULL)
        return instance_complain(i, ERROR, "%s: there is no place for the size.", function);
    if (status == OK)
        *size = (size_t)((const Snapshot *)snapshot)->size;
    return status;
}

Status snapshot_serialise(Instance *i, const char *function, const void *snapshot, void *bytes,
                          size_t size)
{
    const Status status = check_snapshot(i, function, snapshot);
    if (status != OK)
        return status;
    const size_t needed = (size_t)((const Snapshot *)snapshot)->size;
    if (bytes == NULL || size < needed)
        return instance_complain(i, ERROR, "%s: %d bytes are given, %d are needed.", function,
                                 (int)size, (int)needed);
    const uint64_t checksum = checksum_of(snapshot);
    memcpy(bytes, snapshot, needed);
    memcpy((char *)bytes + offsetof(Snapshot, checksum), &checksum, sizeof checksum);
    return OK;
}

Status snapshot_deserialise(Instance *i, const char *function, const void *bytes, size_t size,
                            void **snapshot)
{
    const Status status = instance_expect(i, function, ~(uint32_t)PHASE_DEAD);
    if (status != OK)
        return status;
    uint64_t needed = size_with(0);
    if (bytes != NULL && size >= needed)
        memcpy(&needed, (const char *)bytes + offsetof(Snapshot, size), sizeof needed);
    if (bytes == NULL || snapshot == NULL || size < needed)
        return instance_complain(i, ERROR, "%s: %d bytes are given, %d are needed.", function,
                                 (int)size, (int)needed);
    Snapshot *s = platform_allocate(room());
    if (s == NULL)
        return instance_complain(i, ERROR, "%s: memory has run out.", function);
    memcpy(s, bytes, needed < room() ? (size_t)needed : room());
    Status result = check_snapshot(i, function, s);
    if (result == OK && s->checksum != checksum_of(s))
        result = instance_complain(i, ERROR, "%s: the bytes of the state are damaged.", function);
    if (result != OK) {
        platform_free(s, room());
        return result;
    }
    *snapshot = s;
    return OK;
}
