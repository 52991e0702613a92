/* A text file of numbers into an array, read in one pass. */
#include "platform.h"
#include "report.h"

typedef struct {
    intptr_t file;
    size_t position, length;
    char buffer[512];
} Reader;

enum { END = -1, FAILED = -2 };

static int next_character(Reader *r)
{
    if (r->position == r->length) {
        const intptr_t count = platform_read(r->file, r->buffer, sizeof r->buffer);
        if (count <= 0)
            return count == 0 ? END : FAILED;
        r->position = 0;
        r->length = (size_t)count;
    }
    return (unsigned char)r->buffer[r->position++];
}

static bool separates(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';'; }

/* The numbers of one line: how many were read into values[columns], or -1 for anything else. */
static int parse_line(const char *text, size_t columns, double *values)
{
    int count = 0;
    for (;;) {
        while (separates(*text))
            ++text;
        if (*text == '\0')
            return count;
        double value;
        if (!parse_number(&text, &value) || (*text != '\0' && !separates(*text)))
            return -1;
        if ((size_t)count < columns)
            values[count] = value;
        ++count;
    }
}

/* Whether a field, up to `end`, is nan, inf or infinity, as programs write what is no number. */
static bool is_no_number(const char *text, const char *end)
{
    static const char *const words[] = {"nan", "inf", "infinity"};
    for (size_t word = 0; word < sizeof words / sizeof *words; ++word) {
        const char *at = text, *letter = words[word];
        while (at < end && *letter != '\0' && (*at | 32) == *letter)
            ++at, ++letter;
        if (at == end && *letter == '\0')
            return true;
    }
    return false;
}

/* Whether a line names columns: no field begins as a number does, and none stands for one. */
static bool is_heading(const char *text)
{
    while (*text != '\0') {
        while (separates(*text))
            ++text;
        const char *end = text;
        while (*end != '\0' && !separates(*end))
            ++end;
        const bool like_number = (*text >= '0' && *text <= '9') || (*text >= '+' && *text <= '.');
        if (end > text && (like_number || is_no_number(text, end)))
            return false;
        text = end;
    }
    return true;
}

/* One line without its end; false at the end of the file. `last` is the character that ended it. */
static bool read_line(Reader *reader, char *line, size_t capacity, int *last, bool *too_long)
{
    size_t length = 0;
    *too_long = false;
    while ((*last = next_character(reader)) >= 0 && *last != '\n') {
        if (length + 1 < capacity)
            line[length++] = (char)*last;
        else
            *too_long = true;
    }
    if (length > 0 && line[length - 1] == '\r')
        --length;
    line[length] = '\0';
    return length > 0 || *last >= 0;
}

const char *report_read_table(Report *r, const char *path, size_t columns, size_t capacity,
                              double *rows, size_t *count)
{
    enum { LINE = 512, COLUMNS = 16 };
    char line[LINE] = "";
    double values[COLUMNS];
    Reader reader = {platform_open(path), 0, 0, {0}};
    if (reader.file < 0)
        return report_format(r, "The file '%s' cannot be opened; give a path to a text file of "
                                "numbers, absolute or from where the program was started.", path);
    const char *problem = NULL;
    bool heading_seen = false, too_long = false;
    int number = 0, last = 0;
    *count = 0;
    while (problem == NULL && read_line(&reader, line, LINE, &last, &too_long)) {
        const char *text = line;
        if (++number == 1 && memcmp(line, "\xEF\xBB\xBF", 3) == 0)
            text += 3; /* a byte order mark is not data */
        const int found = *text == '#' ? 0 : parse_line(text, columns, values);
        if (too_long)
            problem = report_format(r, "%s, line %d: the line is longer than %d characters.", path,
                                    number, LINE - 1);
        else if (found < 0 && !heading_seen && *count == 0 && is_heading(text))
            heading_seen = true;
        else if (found < 0)
            problem = report_format(r, "%s, line %d: '%s' is not a list of finite numbers.", path,
                                    number, line);
        else if (found > 0 && (size_t)found != columns)
            problem = report_format(r, "%s, line %d: there are %d numbers; %d are needed.", path,
                                    number, found, (int)columns);
        else if (found > 0 && *count == capacity)
            problem = report_format(r, "%s, line %d: there are more than %d rows; shorten the file "
                                       "or sample it more coarsely.", path, number, (int)capacity);
        else if (found > 0)
            for (size_t i = 0; i < columns; ++i)
                rows[columns * *count + i] = values[i];
        if (problem == NULL && found > 0)
            ++*count;
    }
    platform_close(reader.file);
    if (problem == NULL && last == FAILED)
        problem = report_format(r, "The file '%s' cannot be read to its end.", path);
    if (problem == NULL && *count == 0)
        problem = report_format(r, "The file '%s' holds no numbers.", path);
    return problem;
}
