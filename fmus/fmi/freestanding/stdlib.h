/* The FMI headers include <stdlib.h> for size_t; freestanding builds have only <stddef.h>. */
#include <stddef.h>
