/* plait/extend/plugin.h: what a plug-in is: a shared library that adds codecs, filters and backends
 * to a program that uses plait. C11 and C++. docs/plugins.md explains it; examples/own_codec.c is
 * one.
 *
 * A plug-in exports one function, plait_plugin_v1(). plait calls it once, when a program loads the
 * plug-in (`plait --plugin FILE`, PLAIT_PLUGINS, plait::Plugins, plait_plugin_load()). The function
 * adds what the plug-in has, and returns 0. If it returns anything else, or if one addition is
 * refused, plait adds nothing of the plug-in. A plug-in stays loaded until the process ends.
 *
 * Codecs and filters are C functions, so any compiler can build them. Backends are classes of C++:
 * plait/extend/plugin_in_cpp.h adds them, and refuses a plug-in that was built against another
 * interface of plait.
 *
 * Names have the characters [A-Za-z0-9_-]. Stores keep the names, so two plug-ins must not give one
 * name to different codecs. Names of plait itself never begin with "x-"; yours should.
 *
 * No C++ exception may leave a function of a plug-in. */
#ifndef PLAIT_PLUGIN_H
#define PLAIT_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define PLAIT_PLUGIN_EXPORT __attribute__((visibility("default")))
#else
#define PLAIT_PLUGIN_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(readability-identifier-naming): C, with the names of plait.h */

/* The structures below. It grows when a member is added at the end of one of them. */
#define PLAIT_PLUGIN_ABI_VERSION 1u

/* A compressor of one block. Members that may be NULL say so. plait copies the structure and the
 * texts; the functions must stay.
 *
 * A state is what open() makes. Only one thread at a time uses a state, and plait makes one for
 * each thread that codes at the same time. If `open` is NULL, the codec takes no options, and its
 * functions get NULL as the state, from any number of threads at the same time. */
typedef struct plait_codec {
  size_t struct_size; /* sizeof(plait_codec) */
  const char* name;
  const char* summary; /* one line, which also explains the options */

  /* `options` is the text after the colon of "NAME:OPTIONS", or "". Returns NULL for options that
   * the codec does not take. May be NULL. */
  void* (*open)(const char* options);
  /* Frees a state. May be NULL. */
  void (*close)(void* state);
  /* The most memory, in bytes, that a state keeps after coding blocks of up to `raw_bytes`. plait
   * subtracts it from the budget of the store. NULL: 0. */
  size_t (*memory_bytes)(const void* state, size_t raw_bytes);

  /* The largest number of bytes that compress() can make of `raw_bytes`. */
  size_t (*bound)(const void* state, size_t raw_bytes);
  /* Writes the encoded block to `into`, which has `into_bytes` bytes, and returns the number of
   * bytes written; 0 if the encoded block does not fit. */
  size_t (*compress)(void* state, const void* raw, size_t raw_bytes, void* into, size_t into_bytes);
  /* Fills exactly `raw_bytes` bytes and returns 0; or returns anything else, for bytes that are not
   * an encoded block of this size. `stored` comes from a disk and may be damaged: the function must
   * not access a byte outside of both ranges, whatever the bytes are. */
  int32_t (*decompress)(void* state, const void* stored, size_t stored_bytes, void* raw,
                        size_t raw_bytes);
} plait_codec;

/* A reversible transform of one block. It keeps the size and makes the block compress better. As in
 * plait_codec, except that any number of threads may use one state at the same time. */
typedef struct plait_filter {
  size_t struct_size; /* sizeof(plait_filter) */
  const char* name;
  const char* summary;

  void* (*open)(const char* options); /* may be NULL, as in plait_codec */
  void (*close)(void* state);         /* may be NULL */

  /* `raw` and `filtered` have `bytes` bytes each and do not overlap. `component_bytes` is the size
   * of one number of the attribute: 1, 2, 4 or 8. */
  void (*encode)(const void* state, const void* raw, void* filtered, size_t bytes,
                 size_t component_bytes);
  /* The inverse of encode(). Accepts any bytes. */
  void (*decode)(const void* state, const void* filtered, void* raw, size_t bytes,
                 size_t component_bytes);
} plait_filter;

typedef struct plait_host plait_host;
/* What plait gives to a plug-in. Valid until plait_plugin_v1() returns. */
struct plait_host {
  size_t struct_size;
  uint32_t abi_version; /* PLAIT_PLUGIN_ABI_VERSION of the library */
  const char* version;  /* of the library, such as "0.1.0" */
  void* registry;       /* of the library */

  /* Return 0, or anything else if the addition was refused; plait has the reason. */
  int32_t (*add_codec)(const plait_host* host, const plait_codec* codec);
  int32_t (*add_filter)(const plait_host* host, const plait_filter* filter);
  /* Tells why the plug-in cannot be used here: one line. plait then adds nothing of the plug-in. */
  void (*refuse)(const plait_host* host, const char* reason);
  /* For plait/extend/plugin_in_cpp.h. NULL if `stamp` is not that of the library. */
  void* (*cpp_registry)(const plait_host* host, const char* stamp);
};

/* Defined by the plug-in. Returns 0 if the plug-in can be used. */
PLAIT_PLUGIN_EXPORT int32_t plait_plugin_v1(const plait_host* host);
/* NOLINTEND(readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
