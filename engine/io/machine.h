// io/machine.h: what a process learns of its machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_NAMESPACE

/// The path from the root. Errors: kNotFound for a relative path if the current directory has been
/// removed.
std::filesystem::path absolute_path(const std::filesystem::path& path);

/// Bytes that this process can still allocate without swapping. This is the minimum of three
/// figures: the available memory of the system (MemAvailable in /proc/meminfo), the free memory in
/// each memory cgroup of the process (version 1 or 2, page cache counted as free), and the rest of
/// RLIMIT_AS. 2^64 - 1 if none of the three is known. Pinned by tests/engine/io/machine_test.cpp.
std::uint64_t available_memory_bytes();

/// Free bytes that a process without root privileges may use on the file system of `path`. If
/// `path` does not exist, the nearest existing directory above it counts. 2^64 - 1 if the system
/// does not tell: then a full disk is an error of a write. Errors: as absolute_path().
std::uint64_t free_disk_bytes(const std::filesystem::path& path);

/// The size in bytes of the largest file that this process may write (RLIMIT_FSIZE). 2^64 - 1 means
/// no limit.
std::uint64_t largest_file_bytes();

PLAIT_END_NAMESPACE

PLAIT_BEGIN_PRIVATE_NAMESPACE

// How much of a file is on the disk. A sparse file costs nothing and can be of any
// size, so its size is no reason to spend time or memory on it.

/// The bytes of the file that are not in holes (SEEK_DATA), all of them where the file system does
/// not know holes. Stops to count at `enough`, and may return more.
std::uint64_t bytes_on_disk(const File& file, std::uint64_t enough);

// The name of this machine in names of files, so that no machine takes the
// unfinished work of another one for its own.

/// Processes with the same two see each other's locks (flock), also from different containers. The
/// name of the host alone does not say that: on many file systems two machines of one name, as
/// containers often have, do not see each other's locks.
struct OwnMachine {
  std::string host;   ///< at most 32 characters of [A-Za-z0-9_.]
  std::string start;  ///< of its kernel, 8 characters; random if the system does not tell it
};
const OwnMachine& own_machine();

/// 8 hexadecimal digits.
std::string random_hex();

/// Who makes something, as names of unfinished work tell it.
struct Maker {
  std::string_view host, start;  ///< OwnMachine; both may be empty
  std::string_view process;      ///< has_ended(); may be empty
};
/// "HOST-START-PROCESS.RANDOM", which names this process, and no other name.
std::string new_maker_name();
/// Nothing for other texts. The result refers to `name`.
std::optional<Maker> read_maker(std::string_view name);
/// Whether a process of this machine is known to have ended: its number, with that of the namespace
/// of process numbers (of a container), is that of no process. False for other machines' processes.
bool has_ended(std::string_view process) noexcept;

PLAIT_END_NAMESPACE
