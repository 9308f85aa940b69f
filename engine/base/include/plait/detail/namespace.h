// plait/detail/namespace.h: how the library's files open their namespace.
//
// For the linker plait::Store is plait::v0::Store. So a program that was compiled with the headers
// of another binary interface does not link, where otherwise it would run and crash. The number is
// the one in the library's soname. Programs do not write it.
//
// Public headers use PLAIT_BEGIN_NAMESPACE: the shared library exports what they declare. Private
// headers whose functions the program calls use it too, because the program links the shared
// library. All other files of the library use PLAIT_BEGIN_PRIVATE_NAMESPACE: their names stay
// inside the shared library.
#pragma once

#if __cplusplus < 202002L
#error "plait needs C++20: compile with -std=c++20 (CMake: target_compile_features(... cxx_std_20))"
#endif

#define PLAIT_BEGIN_NAMESPACE \
  namespace plait {           \
  inline namespace [[gnu::visibility("default")]] v0 {
#define PLAIT_BEGIN_PRIVATE_NAMESPACE \
  namespace plait {                   \
  inline namespace v0 {
#define PLAIT_END_NAMESPACE \
  }                         \
  }

/// For a function template of a public header that the library instantiates: the compiler would
/// take the visibility of the private file where the template is defined.
#define PLAIT_EXPORT [[gnu::visibility("default")]]
