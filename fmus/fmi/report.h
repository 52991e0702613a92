/* The report that the glue hands to a model: the sentence buffer and the way to the log. */
#ifndef COHAPTIC_REPORT_H
#define COHAPTIC_REPORT_H

#include <stdarg.h>

#include "model.h"

enum { REPORT_CAPACITY = 512 };

struct Report {
    void (*log)(void *context, const char *sentence);
    void *context;
    double start_time;
    Severity severity;
    bool outputs_are_current;
    char text[REPORT_CAPACITY];
};

const char *report_format_list(Report *r, const char *format, va_list arguments);

/* The double nearest to the decimal number at *text; advances *text behind it. False where there
   is no finite number. Correctly rounded for up to 40 significant digits. */
bool parse_number(const char **text, double *value);

#endif
