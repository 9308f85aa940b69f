#include "random_reads.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>
#include <vector>

#include "confined.h"
#include "plait/error.h"
#include "plait/file.h"
#include "support.h"

namespace plait::bench {
namespace {

constexpr int kSeconds = 1;

double by_fio(const RandomReads& reads) {
  // Through the page cache each job has a part of the file.
  const auto jobs = static_cast<std::uint64_t>(reads.jobs);
  const std::uint64_t part = File(reads.file, OpenMode::kRead).size() / reads.block_bytes / jobs;
  const std::string how = reads.direct
                              ? fmt::format("--direct=1 --time_based --runtime={}", kSeconds)
                              : fmt::format("--direct=0 --size={0} --offset_increment={0}",
                                            std::max<std::uint64_t>(part, 1) * reads.block_bytes);
  const std::string text = output_of(fmt::format(
      "fio --name=floor --filename={} --rw=randread --bs={} --ioengine={} --numjobs={} "
      "--iodepth={} --thread {} --group_reporting --readonly --output-format=json 2>/dev/null",
      reads.file.native(), reads.block_bytes, reads.engine, reads.jobs, reads.depth, how));
  if (text.empty()) throw Error(ErrorCode::kIo, "fio failed");
  return nlohmann::json::parse(text.substr(text.find('{')))["jobs"][0]["read"]["bw_bytes"]
      .get<double>();
}

double by_threads(const RandomReads& reads) {
  const std::uint64_t blocks = File(reads.file, OpenMode::kRead).size() / reads.block_bytes;
  std::atomic<std::uint64_t> bytes = 0;
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(reads.jobs * reads.depth));
  const double passed = seconds([&] {
    std::vector<std::jthread> threads;
    for (std::size_t thread = 0; thread < failures.size(); ++thread)
      threads.emplace_back([&, thread] {
        try {
          const File file(reads.file, OpenMode::kRead,
                          reads.direct ? Caching::kNone : Caching::kPageCache);
          const auto free = [](std::byte* memory) {
            ::operator delete(memory, std::align_val_t(4096));
          };
          const std::unique_ptr<std::byte, decltype(free)> memory(
              static_cast<std::byte*>(::operator new(reads.block_bytes, std::align_val_t(4096))),
              free);
          std::mt19937_64 random(thread);
          const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kSeconds);
          while (std::chrono::steady_clock::now() < end) {
            file.read_at(random() % blocks * reads.block_bytes, {memory.get(), reads.block_bytes});
            bytes += reads.block_bytes;
          }
        } catch (...) {
          failures[thread] = std::current_exception();
        }
      });
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  return static_cast<double>(bytes) / passed;
}

}  // namespace

bool have_fio() {
  static const bool have = !output_of("fio --version 2>/dev/null").empty();
  return have;
}

double bytes_per_second(const RandomReads& reads) {
  return have_fio() ? by_fio(reads) : by_threads(reads);
}

}  // namespace plait::bench
