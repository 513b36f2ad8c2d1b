// Which share of the CPU time of a piece of work is spent inside a shared library: the program counter, sampled.
#pragma once

#include <link.h>
#include <sys/time.h>
#include <ucontext.h>

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace tress::bench {

struct LibraryShare {
  std::uint64_t samples = 0;  ///< of the program counter; 0 where it cannot be read
  std::uint64_t inside = 0;
};

namespace detail {

inline std::uintptr_t library_begin, library_end;
inline volatile std::uint64_t counters_seen, counters_inside;

inline std::uintptr_t program_counter([[maybe_unused]] const ucontext_t& context) {
#if defined(__x86_64__)
  return static_cast<std::uintptr_t>(context.uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
  return static_cast<std::uintptr_t>(context.uc_mcontext.pc);
#else
  return 0;
#endif
}

inline void look(int, siginfo_t*, void* context) {
  const std::uintptr_t at = program_counter(*static_cast<const ucontext_t*>(context));
  if (at == 0) return;
  counters_seen = counters_seen + 1;
  if (at >= library_begin && at < library_end) counters_inside = counters_inside + 1;
}

inline int find_library(dl_phdr_info* info, std::size_t, void* name) {
  if (std::string(info->dlpi_name).find(*static_cast<const std::string*>(name)) == std::string::npos) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    library_begin = info->dlpi_addr + part.p_vaddr;
    library_end = library_begin + part.p_memsz;
  }
  return 1;
}

}  // namespace detail

/// Runs `work` while a timer of CPU time looks where the program is, at most a thousand times a second (a kernel may
/// look at its own ticks only). `library`: a part of the library's file name. One thread.
inline LibraryShare library_share(std::string library, const std::function<void()>& work) {
  detail::library_begin = detail::library_end = 0;
  detail::counters_seen = 0;
  detail::counters_inside = 0;
  dl_iterate_phdr(detail::find_library, &library);
  struct sigaction look{}, before{};
  look.sa_sigaction = detail::look;
  look.sa_flags = SA_SIGINFO | SA_RESTART;
  sigaction(SIGPROF, &look, &before);
  const itimerval period{{0, 1000}, {0, 1000}}, off{};
  setitimer(ITIMER_PROF, &period, nullptr);
  work();
  setitimer(ITIMER_PROF, &off, nullptr);
  sigaction(SIGPROF, &before, nullptr);
  return {detail::counters_seen, detail::counters_inside};
}

}  // namespace tress::bench
