/* Whether what a component has put out are numbers: called after each of its calls, where with cold
   caches a call of NumPy costs several microseconds. */

#include "kernel.h"

/* The place in `which` of the first cell that is not a number; -1 for none. */
int64_t kernel_first_nan(const double *cells, const int64_t *which, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        if (cells[which[i]] != cells[which[i]])
            return i;
    return -1;
}
