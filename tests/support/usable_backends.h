// tests/support/usable_backends.h: the built-in backends that this machine can use.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/registry.h"

namespace plait::test {

/// If the kernel or the build refuses a backend, prints that once to standard error.
inline const std::vector<std::string>& usable_backends() {
  static const std::vector<std::string> usable = [] {
    std::vector<std::string> names = default_backends().names();
    std::erase_if(names, [](const std::string& name) {
      try {
        default_backends().find(name).check_machine();
        return false;
      } catch (const Error& error) {
        std::fprintf(stderr, "skipped backend %s: %s\n", name.c_str(), error.what());
        return error.code() == ErrorCode::kNotSupported;
      }
    });
    return names;
  }();
  return usable;
}

}  // namespace plait::test
