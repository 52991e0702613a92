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
