/* Memory and files: raw system calls on Linux, kernel32 on Windows, libSystem on macOS; the C
   library in hosted builds (COHAPTIC_HOSTED, for sanitizers). */
#include "platform.h"

#if defined(COHAPTIC_HOSTED) || defined(__APPLE__)

/* Declared here because no SDK header is at hand when cross-compiling. */
void *calloc(size_t count, size_t size);
void free(void *memory);
int open(const char *path, int flags, ...);
ptrdiff_t read(int file, void *buffer, size_t capacity);
int close(int file);

void *platform_allocate(size_t bytes) { return calloc(1, bytes); }

void platform_free(void *memory, size_t bytes)
{
    (void)bytes;
    free(memory);
}

intptr_t platform_open(const char *utf8_path) { return open(utf8_path, 0); }

intptr_t platform_read(intptr_t file, char *buffer, size_t capacity)
{
    return read((int)file, buffer, capacity);
}

void platform_close(intptr_t file) { close((int)file); }

#elif defined(_WIN32)

#define KERNEL32 __declspec(dllimport)
KERNEL32 void *__stdcall GetProcessHeap(void);
KERNEL32 void *__stdcall HeapAlloc(void *heap, uint32_t flags, size_t bytes);
KERNEL32 int __stdcall HeapFree(void *heap, uint32_t flags, void *memory);
KERNEL32 int __stdcall MultiByteToWideChar(uint32_t code_page, uint32_t flags, const char *text,
                                           int length, uint16_t *wide, int capacity);
KERNEL32 void *__stdcall CreateFileW(const uint16_t *path, uint32_t access, uint32_t share,
                                     void *security, uint32_t creation, uint32_t attributes,
                                     void *template_file);
KERNEL32 int __stdcall ReadFile(void *file, void *buffer, uint32_t capacity, uint32_t *count,
                                void *overlapped);
KERNEL32 int __stdcall CloseHandle(void *file);

/* What the linker expects of a DLL that uses floating point and has no C runtime. */
int _fltused = 0;

int __stdcall DllMainCRTStartup(void *module, uint32_t reason, void *reserved)
{
    (void)module, (void)reason, (void)reserved;
    return 1;
}

void *platform_allocate(size_t bytes)
{
    const uint32_t zero_memory = 8;
    return HeapAlloc(GetProcessHeap(), zero_memory, bytes);
}

void platform_free(void *memory, size_t bytes)
{
    (void)bytes;
    if (memory != NULL)
        HeapFree(GetProcessHeap(), 0, memory);
}

intptr_t platform_open(const char *utf8_path)
{
    enum { UTF8 = 65001, READ_SHARED = 1, OPEN_EXISTING = 3, NORMAL = 0x80, CAPACITY = 600 };
    uint16_t wide[CAPACITY];
    if (MultiByteToWideChar(UTF8, 0, utf8_path, -1, wide, CAPACITY) <= 0)
        return -1;
    return (intptr_t)CreateFileW(wide, 0x80000000u, READ_SHARED, NULL, OPEN_EXISTING, NORMAL, NULL);
}

intptr_t platform_read(intptr_t file, char *buffer, size_t capacity)
{
    uint32_t count = 0;
    return ReadFile((void *)file, buffer, (uint32_t)capacity, &count, NULL) ? (intptr_t)count : -1;
}

void platform_close(intptr_t file) { CloseHandle((void *)file); }

#elif defined(__linux__)

#if defined(__x86_64__)
enum { READ = 0, CLOSE = 3, MMAP = 9, MUNMAP = 11, OPENAT = 257 };

static intptr_t system_call(intptr_t number, intptr_t a, intptr_t b, intptr_t c, intptr_t d,
                            intptr_t e, intptr_t f)
{
    register intptr_t r10 __asm__("r10") = d;
    register intptr_t r8 __asm__("r8") = e;
    register intptr_t r9 __asm__("r9") = f;
    intptr_t result;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c), "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
    return result;
}
#elif defined(__aarch64__)
enum { READ = 63, CLOSE = 57, MMAP = 222, MUNMAP = 215, OPENAT = 56 };

static intptr_t system_call(intptr_t number, intptr_t a, intptr_t b, intptr_t c, intptr_t d,
                            intptr_t e, intptr_t f)
{
    register intptr_t x8 __asm__("x8") = number;
    register intptr_t x0 __asm__("x0") = a;
    register intptr_t x1 __asm__("x1") = b;
    register intptr_t x2 __asm__("x2") = c;
    register intptr_t x3 __asm__("x3") = d;
    register intptr_t x4 __asm__("x4") = e;
    register intptr_t x5 __asm__("x5") = f;
    __asm__ volatile("svc 0"
                     : "+r"(x0)
                     : "r"(x8), "r"(x1), "r"(x2), "r"(x3), "r"(x4), "r"(x5)
                     : "memory");
    return x0;
}
#endif

/* A page begins at the same place of a processor's first cache as every other, so that instances which
   all began there would push each other out of it: each begins further on than its neighbour, by what
   room its last page has. */
enum { PAGE = 4096, LINE = 64, LINES_APART = 11 };

static intptr_t line_of_its_own(intptr_t page, size_t bytes)
{
    const intptr_t room = (intptr_t)(-bytes % PAGE) / LINE + 1;
    return page / PAGE * LINES_APART % room * LINE;
}

void *platform_allocate(size_t bytes)
{
    const intptr_t read_write = 3, private_anonymous = 0x22;
    intptr_t page = system_call(MMAP, 0, (intptr_t)bytes, read_write, private_anonymous, -1, 0);
    return page < 0 && page > -PAGE ? NULL : (void *)(page + line_of_its_own(page, bytes));
}

void platform_free(void *memory, size_t bytes)
{
    if (memory != NULL)
        system_call(MUNMAP, (intptr_t)memory & -PAGE, (intptr_t)bytes, 0, 0, 0, 0);
}

intptr_t platform_open(const char *utf8_path)
{
    const intptr_t current_directory = -100, close_on_exec = 02000000;
    return system_call(OPENAT, current_directory, (intptr_t)utf8_path, close_on_exec, 0, 0, 0);
}

intptr_t platform_read(intptr_t file, char *buffer, size_t capacity)
{
    return system_call(READ, file, (intptr_t)buffer, (intptr_t)capacity, 0, 0, 0);
}

void platform_close(intptr_t file) { system_call(CLOSE, file, 0, 0, 0, 0, 0); }

#else
#error "no platform layer for this system"
#endif

#if !defined(COHAPTIC_HOSTED) && !defined(__APPLE__)

/* Compilers emit calls to these four even in freestanding code. */

void *memcpy(void *restrict to, const void *restrict from, size_t bytes)
{
    return memmove(to, from, bytes);
}

void *memmove(void *to, const void *from, size_t bytes)
{
    unsigned char *target = to;
    const unsigned char *source = from;
    if ((uintptr_t)target - (uintptr_t)source >= bytes) {
        for (; bytes >= 8; bytes -= 8, target += 8, source += 8) {
            uint64_t word;
            __builtin_memcpy_inline(&word, source, 8);
            __builtin_memcpy_inline(target, &word, 8);
        }
        while (bytes-- > 0)
            *target++ = *source++;
    } else {
        while (bytes-- > 0)
            target[bytes] = source[bytes];
    }
    return to;
}

void *memset(void *to, int value, size_t bytes)
{
    unsigned char *target = to;
    while (bytes-- > 0)
        *target++ = (unsigned char)value;
    return to;
}

int memcmp(const void *a, const void *b, size_t bytes)
{
    const unsigned char *left = a, *right = b;
    for (size_t i = 0; i < bytes; ++i)
        if (left[i] != right[i])
            return left[i] - right[i];
    return 0;
}

#endif
