/* Preloaded into the program: lets one system call fail, takes locks away, or lets the wall clock jump.
 * FAULT_CALL=write|fsync|rename|open|fchmod FAULT_AT=n FAULT_ERRNO=e: its n-th call fails, and says so in FAULT_MARK.
 * FAULT_LOCKS=1: flock says ENOLCK. FAULT_CLOCK=1: every look at the wall clock is a day before or after the last. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

static int fails(const char* call) {
  static atomic_int calls;
  const char *wanted = getenv("FAULT_CALL"), *at = getenv("FAULT_AT"), *error = getenv("FAULT_ERRNO");
  if (!wanted || strcmp(wanted, call) != 0 || !at || !error) return 0;
  if (atomic_fetch_add(&calls, 1) + 1 != atoi(at)) return 0;
  const char* reported = getenv("FAULT_MARK");
  if (reported) close((int)syscall(SYS_openat, AT_FDCWD, reported, O_CREAT | O_WRONLY, 0600));
  errno = atoi(error);
  return 1;
}

/* A disk that is full takes a part first, and the rest of it not. */
ssize_t write(int file, const void* bytes, size_t size) {
  static atomic_int full;
  if (file > 2 && atomic_exchange(&full, 0)) return errno = ENOSPC, -1;
  if (file > 2 && fails("write")) {
    if (size < 2 || errno != ENOSPC) return -1;
    atomic_store(&full, 1);
    size /= 2;
  }
  return syscall(SYS_write, file, bytes, size);
}

int fsync(int file) { return fails("fsync") ? -1 : (int)syscall(SYS_fsync, file); }
int fchmod(int file, mode_t mode) { return fails("fchmod") ? -1 : (int)syscall(SYS_fchmod, file, mode); }
int rename(const char* from, const char* to) {
  return fails("rename") ? -1 : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;
  va_end(more);
  if ((flags & (O_WRONLY | O_RDWR)) && fails("open")) return -1;
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}
int flock(int file, int operation) {
  if (getenv("FAULT_LOCKS")) return errno = ENOLCK, -1;
  return (int)syscall(SYS_flock, file, operation);
}

static time_t jump(void) {
  static atomic_int looks;
  return atomic_fetch_add(&looks, 1) % 2 ? -86400 : 86400;
}
int clock_gettime(clockid_t clock, struct timespec* now) {
  const int status = (int)syscall(SYS_clock_gettime, clock, now);
  if (status == 0 && clock == CLOCK_REALTIME && getenv("FAULT_CLOCK")) now->tv_sec += jump();
  return status;
}
time_t time(time_t* out) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}
