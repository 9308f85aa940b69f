#include "stand_ins.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "plait/error.h"

namespace plait {
namespace {

/// An entry that tries `wanted` when the first store is opened, and uses `wanted` or `other` from
/// then on.
RegisteredBackend with_stand_in(const RegisteredBackend& wanted, const RegisteredBackend& other,
                                const std::function<void(const std::string&)>& warn) {
  const auto refused = std::make_shared<std::optional<bool>>();
  RegisteredBackend entry = wanted;
  entry.check_machine = [=] {
    if (refused->has_value()) return;
    try {
      wanted.check_machine();
      *refused = false;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNotSupported) throw;
      *refused = true;
      warn(fmt::format("{}; using {} instead, whose files are the same", error.what(), other.name));
    }
  };
  entry.open = [=](auto&&... what) {
    return refused->value_or(false) ? other.open(what...) : wanted.open(what...);
  };
  return entry;
}

}  // namespace

BackendRegistry with_stand_ins(const BackendRegistry& backends,
                               const std::function<void(const std::string&)>& warn) {
  BackendRegistry result;
  for (const std::string& name : backends.names())
    result.add(name == "uring" ? with_stand_in(backends.find(name), backends.find("pread"), warn)
                               : backends.find(name));
  result.set_chooser(backends.chooser());
  return result;
}

}  // namespace plait
