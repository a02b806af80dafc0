// Clocks for reports and benchmarks. CPU time is what we quote: wall time on a shared machine says little.
#pragma once

namespace alpenglow {

[[nodiscard]] double thread_cpu_seconds() noexcept;  // CPU time of the calling thread
[[nodiscard]] double process_cpu_seconds() noexcept; // CPU time of all threads of the process
[[nodiscard]] double wall_seconds() noexcept;        // monotonic

} // namespace alpenglow
