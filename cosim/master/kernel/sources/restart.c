/* FMUs back to before tick 0 with other values: for runs that are repeated thousands of times, where a
   call of Python's for each function takes longer than the loop. Whatever is not well is done once
   more from there, which finds the words for it. */

#include "kernel.h"

typedef int (*Plain)(void *instance);
typedef int (*SetUp2)(void *instance, int tolerance_defined, double tolerance, double start,
                      int stop_defined, double stop);
typedef int (*Enter3)(void *instance, bool tolerance_defined, double tolerance, double start,
                      bool stop_defined, double stop);

static int set(const Restart *own, const Setting *setting)
{
    size_t references = (size_t)setting->reference_count;
    if (own->version == 2)
        return ((Access2)setting->function)(own->instance, setting->references, references,
                                            setting->values);
    return ((Access3)setting->function)(own->instance, setting->references, references,
                                        setting->values, (size_t)setting->value_count);
}

static int begin(const Restart *own)
{
    int status = ((Plain)own->reset)(own->instance);
    own->log->used = own->log->grave_used = own->log->messages = 0;
    for (int64_t i = 0; i < own->setting_count && status <= STATUS_WARNING; i++)
        status = set(own, &own->settings[i]);
    return status;
}

static int enter(const Restart *own)
{
    if (own->version == 3)
        return ((Enter3)own->enter)(own->instance, false, 0.0, own->start, true, own->stop);
    int status = ((SetUp2)own->set_up)(own->instance, 0, 0.0, own->start, 1, own->stop);
    return status <= STATUS_WARNING ? ((Plain)own->enter)(own->instance) : status;
}

static int leave(const Restart *own)
{
    return ((Plain)own->leave)(own->instance);
}

static int64_t each(Restart *restarts, int64_t count, int (*act)(const Restart *))
{
    for (int64_t i = 0; i < count; i++) {
        restarts[i].status = act(&restarts[i]);
        if (restarts[i].status > STATUS_WARNING)
            return i;
    }
    return count;
}

/* Reset, values, initialisation mode; the first that is not well, or `count`. */
EXPORT int64_t kernel_restart(Restart *restarts, int64_t count)
{
    int64_t begun = each(restarts, count, begin);
    return begun < count ? begun : each(restarts, count, enter);
}

/* Out of initialisation mode; the first that is not well, or `count`. */
EXPORT int64_t kernel_leave_initialisation(Restart *restarts, int64_t count)
{
    return each(restarts, count, leave);
}
