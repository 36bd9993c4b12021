/* A library to preload (LD_PRELOAD) that makes one call of the C library fail.
 *
 *   FAULT=CALL:N[:ERRNO]   the N-th call of CALL fails, N from 1; ERRNO is a number (default EIO, of memory ENOMEM)
 *   FAULT=CALL:N+[:ERRNO]  that call and all later ones
 *   FAULT_COUNTS=FILE      at exit, a line `CALL COUNT` for each call
 *
 * Calls by standard streams inside the C library do not pass here; qerr writes its results by itself.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WRITE, READ, OPEN, CLOSE, FSYNC, RENAME, LINK, TRUNCATE, SEEK, THREAD, MEMORY, MAP, CALLS };
static const char* const names[CALLS] = {"write",    "read",  "open",   "close",  "fsync", "rename",
                                         "link",     "ftruncate", "lseek", "thread", "malloc", "mmap"};
static atomic_long counts[CALLS];
static int failing = -1, failing_errno = EIO, persistent;
static long failing_at;
static atomic_int ready;

__attribute__((constructor)) static void start(void) {
  const char* fault = getenv("FAULT");
  if (fault) {
    const char* colon = strchr(fault, ':');
    for (int i = 0; colon && i < CALLS; ++i)
      if (strlen(names[i]) == (size_t)(colon - fault) && !strncmp(fault, names[i], (size_t)(colon - fault))) failing = i;
    char* end = NULL;
    if (colon) failing_at = strtol(colon + 1, &end, 10);
    if (failing == MEMORY || failing == MAP) failing_errno = ENOMEM;
    if (failing == THREAD) failing_errno = EAGAIN;
    if (end && *end == '+') persistent = 1, ++end;
    if (end && *end == ':') failing_errno = atoi(end + 1);
    if (failing < 0) {
      static const char wrong[] = "FAULT names no call\n";
      if (write(2, wrong, sizeof wrong - 1)) _exit(99);
    }
  }
  atomic_store(&ready, 1);
}

/* Whether this call is to fail; the calls of the dynamic linker before main are not counted. */
static int fails(int call) {
  if (!atomic_load(&ready)) return 0;
  const long n = atomic_fetch_add(&counts[call], 1) + 1;
  if (call != failing || (persistent ? n < failing_at : n != failing_at)) return 0;
  errno = failing_errno;
  return 1;
}

__attribute__((destructor)) static void finish(void) {
  atomic_store(&ready, 0);
  const char* path = getenv("FAULT_COUNTS");
  if (!path) return;
  FILE* file = fopen(path, "w");
  for (int i = 0; file && i < CALLS; ++i) fprintf(file, "%s %ld\n", names[i], atomic_load(&counts[i]));
  if (file) fclose(file);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int fd, const void* data, size_t size) {
  return fails(WRITE) ? -1 : REAL(write)(fd, data, size);
}
ssize_t read(int fd, void* data, size_t size) { return fails(READ) ? -1 : REAL(read)(fd, data, size); }
ssize_t pread(int fd, void* data, size_t size, off_t at) { return fails(READ) ? -1 : REAL(pread)(fd, data, size, at); }
ssize_t pread64(int fd, void* data, size_t size, off_t at) { return fails(READ) ? -1 : REAL(pread)(fd, data, size, at); }

static mode_t mode_of(int flags, va_list more) {
  return (flags & O_CREAT) || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(more, mode_t) : 0;
}
#define OPEN(name)                                               \
  int name(const char* path, int flags, ...) {                   \
    va_list more;                                                \
    va_start(more, flags);                                       \
    const mode_t mode = mode_of(flags, more);                    \
    va_end(more);                                                \
    return fails(OPEN) ? -1 : REAL(openat)(AT_FDCWD, path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

int close(int fd) {
  if (!fails(CLOSE)) return REAL(close)(fd);
  const int code = errno; /* the descriptor is closed in any case, as on Linux */
  REAL(close)(fd);
  errno = code;
  return -1;
}
int fsync(int fd) { return fails(FSYNC) ? -1 : REAL(fsync)(fd); }
int rename(const char* from, const char* to) { return fails(RENAME) ? -1 : REAL(rename)(from, to); }
int linkat(int a, const char* from, int b, const char* to, int flags) {
  return fails(LINK) ? -1 : REAL(linkat)(a, from, b, to, flags);
}
int ftruncate(int fd, off_t size) { return fails(TRUNCATE) ? -1 : REAL(ftruncate)(fd, size); }
int ftruncate64(int fd, off_t size) { return fails(TRUNCATE) ? -1 : REAL(ftruncate)(fd, size); }
off_t lseek(int fd, off_t at, int whence) { return fails(SEEK) ? -1 : REAL(lseek)(fd, at, whence); }
off_t lseek64(int fd, off_t at, int whence) { return fails(SEEK) ? -1 : REAL(lseek)(fd, at, whence); }

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) {
  return fails(THREAD) ? failing_errno : REAL(pthread_create)(thread, attributes, run, argument);
}

/* dlsym allocates: memory is taken from the C library's own names instead. */
extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) { return fails(MEMORY) ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return fails(MEMORY) ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return fails(MEMORY) ? NULL : __libc_realloc(old, size); }
void* memalign(size_t alignment, size_t size) { return fails(MEMORY) ? NULL : __libc_memalign(alignment, size); }
void* aligned_alloc(size_t alignment, size_t size) { return fails(MEMORY) ? NULL : __libc_memalign(alignment, size); }
int posix_memalign(void** out, size_t alignment, size_t size) {
  if (fails(MEMORY)) return ENOMEM;
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
void* mmap(void* at, size_t size, int protection, int flags, int fd, off_t offset) {
  return fails(MAP) ? MAP_FAILED : REAL(mmap)(at, size, protection, flags, fd, offset);
}
