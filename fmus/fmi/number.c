/* Decimal text to the nearest double, without a C library and with the same bits everywhere.

   Up to 15 digits with a small exponent go through one exact operation (Clinger 1990, the fast
   path); everything else is divided exactly in big integers and rounded once, half to even. */
#include "platform.h"
#include "report.h"

enum { WORDS = 64, MAX_DIGITS = 40 };

typedef struct {
    uint32_t word[WORDS]; /* least significant first */
} Big;

static void multiply_add(Big *b, uint32_t factor, uint32_t addend)
{
    uint64_t carry = addend;
    for (int i = 0; i < WORDS; ++i) {
        carry += (uint64_t)b->word[i] * factor;
        b->word[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

static int bit_length(const Big *b)
{
    for (int i = WORDS - 1; i >= 0; --i)
        if (b->word[i] != 0)
            return 32 * i + 32 - __builtin_clz(b->word[i]);
    return 0;
}

static void shift_left(Big *b, int bits)
{
    const int words = bits / 32, rest = bits % 32;
    for (int i = WORDS - 1; i >= 0; --i) {
        uint64_t pair = i - words >= 0 ? (uint64_t)b->word[i - words] << 32 : 0;
        if (i - words - 1 >= 0)
            pair |= b->word[i - words - 1];
        b->word[i] = (uint32_t)(pair >> (32 - rest));
    }
}

static bool subtract_if_not_below(Big *a, const Big *b)
{
    int i = WORDS - 1;
    while (i > 0 && a->word[i] == b->word[i])
        --i;
    if (a->word[i] < b->word[i])
        return false;
    int64_t borrow = 0;
    for (i = 0; i < WORDS; ++i) {
        borrow += (int64_t)a->word[i] - b->word[i];
        a->word[i] = (uint32_t)borrow;
        borrow >>= 32;
    }
    return true;
}

/* digits[0 .. count) · 10^exponent, rounded to nearest, ties to even. */
static double exact(const char *digits, int count, int exponent)
{
    static const Big zero;
    Big numerator = zero, denominator = zero;
    for (int i = 0; i < count; ++i)
        multiply_add(&numerator, 10, (uint32_t)(digits[i] - '0'));
    denominator.word[0] = 1;
    for (int i = exponent; i > 0; --i)
        multiply_add(&numerator, 10, 0);
    for (int i = exponent; i < 0; ++i)
        multiply_add(&denominator, 10, 0);
    /* Scale by 2^scale so that the quotient lies in [1/2, 1); then take 64 bits of it. */
    int scale = bit_length(&numerator) - bit_length(&denominator);
    if (scale > 0)
        shift_left(&denominator, scale);
    else
        shift_left(&numerator, -scale);
    Big trial = numerator;
    if (subtract_if_not_below(&trial, &denominator)) {
        shift_left(&denominator, 1);
        ++scale;
    }
    uint64_t quotient = 0;
    for (int i = 0; i < 64; ++i) {
        shift_left(&numerator, 1);
        quotient = quotient << 1 | subtract_if_not_below(&numerator, &denominator);
    }
    const bool inexact = bit_length(&numerator) > 0;
    /* The value is quotient · 2^(scale − 64), of which a double keeps 53 bits, a subnormal fewer. */
    int drop = 11;
    if (scale - 1 < -1022)
        drop += -1022 - (scale - 1);
    if (drop > 64)
        return 0.0;
    uint64_t kept = drop == 64 ? 0 : quotient >> drop;
    const uint64_t rest = drop == 64 ? quotient : quotient & (((uint64_t)1 << drop) - 1);
    const uint64_t half = (uint64_t)1 << (drop - 1);
    if (rest > half || (rest == half && (inexact || (kept & 1) != 0)))
        ++kept;
    return scalbn((double)kept, scale - 64 + drop);
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool parse_number(const char **text, double *value)
{
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *p = *text;
    const bool negative = *p == '-';
    if (*p == '-' || *p == '+')
        ++p;
    char digits[MAX_DIGITS + 1];
    int count = 0, exponent = 0;
    bool any = false, fraction = false, dropped = false;
    for (;; ++p) {
        if (*p == '.' && !fraction) {
            fraction = true;
            continue;
        }
        if (!is_digit(*p))
            break;
        any = true;
        exponent -= fraction;
        if (count == 0 && *p == '0')
            continue;
        if (count < MAX_DIGITS) {
            digits[count++] = *p;
        } else {
            dropped = dropped || *p != '0';
            ++exponent;
        }
    }
    if (!any)
        return false;
    if ((*p == 'e' || *p == 'E') &&
        (is_digit(p[1]) || ((p[1] == '-' || p[1] == '+') && is_digit(p[2])))) {
        const bool minus = p[1] == '-';
        int given = 0;
        for (p += is_digit(p[1]) ? 1 : 2; is_digit(*p); ++p)
            given = given < 100000 ? 10 * given + (*p - '0') : given;
        exponent += minus ? -given : given;
    }
    if (dropped) { /* what was dropped is not zero: stay off a tie */
        digits[count++] = '1';
        --exponent;
    }
    while (count > 0 && digits[count - 1] == '0') {
        --count;
        ++exponent;
    }
    double magnitude = 0.0;
    if (count > 0 && exponent + count > 310)
        return false;
    if (count > 0 && exponent + count > -345) {
        if (count <= 15 && exponent >= -22 && exponent <= 22) {
            for (int i = 0; i < count; ++i)
                magnitude = 10.0 * magnitude + (digits[i] - '0');
            magnitude = exponent < 0 ? magnitude / power[-exponent] : magnitude * power[exponent];
        } else {
            magnitude = exact(digits, count, exponent);
        }
    }
    if (!isfinite(magnitude))
        return false;
    *text = p;
    *value = negative ? -magnitude : magnitude;
    return true;
}
