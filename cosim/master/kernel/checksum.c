/* The checksum of a saved state of our own FMUs (fmus/fmi/snapshot.c): who changes a number in one
   puts it right. */

#include "kernel.h"

/* FNV-1a over words of eight bytes. */
uint64_t kernel_checksum(const uint64_t *words, int64_t count)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (int64_t i = 0; i < count; i++)
        hash = (hash ^ words[i]) * 0x100000001b3u;
    return hash;
}
