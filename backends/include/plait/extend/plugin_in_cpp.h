// plait/extend/plugin_in_cpp.h: for plug-ins in C++, which add backends, or codecs and filters
// that are classes. examples/own_backend.cpp is one:
//
//   extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
//     return plait::add_in_cpp(host, [](plait::PluginRegistry& registry) {
//       registry.add(plait::RegisteredBackend{...});
//     });
//   }
//
// The classes of such a plug-in and of the library must have the same layout. So the plug-in must
// be built against the headers of the version that loads it, and against the same standard library.
// add_in_cpp() compares a stamp of both, and refuses the plug-in in words if they differ.
#pragma once

#include <cstdint>
#include <exception>
#include <version>

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/extend/plugin.h"
#include "plait/version.h"

#define PLAIT_TEXT_OF_VALUE(number) #number
#define PLAIT_TEXT_OF(number) PLAIT_TEXT_OF_VALUE(number)

#if defined(_LIBCPP_ABI_VERSION)
#define PLAIT_STANDARD_LIBRARY "libc++ " PLAIT_TEXT_OF(_LIBCPP_ABI_VERSION)
#elif defined(_GLIBCXX_DEBUG)
#define PLAIT_STANDARD_LIBRARY "libstdc++ cxx11=" PLAIT_TEXT_OF(_GLIBCXX_USE_CXX11_ABI) " debug"
#elif defined(__GLIBCXX__)
#define PLAIT_STANDARD_LIBRARY "libstdc++ cxx11=" PLAIT_TEXT_OF(_GLIBCXX_USE_CXX11_ABI)
#else
#define PLAIT_STANDARD_LIBRARY "unknown"
#endif

/// The interface in C++ that a source was compiled against. Before version 1.0, each minor version
/// may change the interface. GCC and Clang lay out classes in the same way (Itanium C++ ABI), so
/// the compiler is not part of the stamp.
#define PLAIT_CPP_STAMP                                          \
  "plait " PLAIT_TEXT_OF(PLAIT_VERSION_MAJOR) "." PLAIT_TEXT_OF( \
      PLAIT_VERSION_MINOR) " v0, " PLAIT_STANDARD_LIBRARY

PLAIT_BEGIN_NAMESPACE

/// What a plug-in adds to. The names must be free, and have the characters [A-Za-z0-9_-]. Errors:
/// kInvalidArgument. If one addition is refused, nothing of the plug-in is added.
class PluginRegistry {
 public:
  virtual void add(RegisteredBackend entry) = 0;
  virtual void add(RegisteredCodec entry) = 0;
  virtual void add(RegisteredFilter entry) = 0;

 protected:
  ~PluginRegistry() = default;
};

/// Calls `add` with the registry of the program that loads the plug-in. Returns the result for
/// plait_plugin_v1(): 0, or 1 if the stamps differ or `add` throws; the host then has the reason.
template <class Add>
std::int32_t add_in_cpp(const plait_host* host, const Add& add) noexcept {
  auto* const registry = static_cast<PluginRegistry*>(host->cpp_registry(host, PLAIT_CPP_STAMP));
  if (registry == nullptr) return 1;
  try {
    add(*registry);
    return 0;
  } catch (const std::exception& error) {
    host->refuse(host, error.what());
  } catch (...) {
    host->refuse(host, "an exception of an unknown type");
  }
  return 1;
}

PLAIT_END_NAMESPACE
