// tests/support/eventually.h: waits for what another thread does, where nothing else tells of it.
#pragma once

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace plait::test {

/// Asks again and again, while other threads have their turn, whether the condition holds. False if
/// it does not hold after ten minutes: a busy machine may take long, and CTest ends a test soon
/// after.
template <class Condition>
bool eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(10);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Whether every other thread of this process waits for something.
inline bool other_threads_sleep() {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == std::to_string(::gettid())) continue;
    std::ifstream file(task.path() / "stat");
    std::string text;
    if (!std::getline(file, text)) continue;  // the thread has ended
    if (text.substr(text.rfind(')') + 1, 2) != " S") return false;
  }
  return true;
}

}  // namespace plait::test
