/* What is done with a whole array in one pass, where Python would go from number to number. */

#include "kernel.h"

/* Whether what a component has put out are numbers: the place in `which` of the first cell that is
   not; -1 for none. Called after each of its calls, where with cold caches a call of NumPy costs
   several microseconds. */
int64_t kernel_first_nan(const double *cells, const int64_t *which, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        if (cells[which[i]] != cells[which[i]])
            return i;
    return -1;
}

/* The checksum of a saved state of our own FMUs (fmus/fmi/snapshot.c), by which who changes a number
   in one puts it right: FNV-1a over words of eight bytes. */
uint64_t kernel_checksum(const uint64_t *words, int64_t count)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (int64_t i = 0; i < count; i++)
        hash = (hash ^ words[i]) * 0x100000001b3u;
    return hash;
}

/* Whether values that came over a link may be believed: in one pass what
   cosim/link/stream/admission.py does in several calls. Nothing is written unless all of them fit. */
enum { ADMIT_FITS = 0, ADMIT_OUT_OF_RANGE = 1, ADMIT_JUMP = 2 };
static const double EXACT = 9007199254740992.0; /* 2^53: from there on every double is whole */

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

static bool is_whole(double value)
{
    return magnitude(value) >= EXACT || (double)(int64_t)value == value;
}

/* `ticks` base ticks from the reference (0: there is none); `step` is what one of them allows. The
   values are copied to `out`, and to `reference` where they are the newest. */
EXPORT int64_t link_admit(const Admission *admission, const double *values, int64_t ticks,
                          double *out, int64_t newest)
{
    const int64_t size = admission->size;
    for (int64_t i = 0; i < size; i++) {
        /* A NaN compares false with everything, so both conditions have to hold. */
        if (!(values[i] >= admission->minimum[i] && values[i] <= admission->maximum[i]))
            return ADMIT_OUT_OF_RANGE;
        if (admission->whole[i] && !is_whole(values[i]))
            return ADMIT_OUT_OF_RANGE;
    }
    if (ticks)
        for (int64_t i = 0; i < size; i++)
            if (!(magnitude(values[i] - admission->reference[i])
                  <= admission->step[i] * (double)ticks))
                return ADMIT_JUMP;
    for (int64_t i = 0; i < size; i++)
        out[i] = values[i];
    if (newest)
        for (int64_t i = 0; i < size; i++)
            admission->reference[i] = values[i];
    return ADMIT_FITS;
}
