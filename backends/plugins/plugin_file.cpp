#include "plugins/plugin_file.h"

#include <dlfcn.h>
#include <elf.h>
#include <fmt/format.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "io/machine.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr const char* kEntryName = "plait_plugin_v1";

[[noreturn]] void refuse_file(const std::filesystem::path& path, std::string_view found) {
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("load plug-in {}: expected a shared library, found {}", path.native(), found));
}

/// Refuses what is no shared library, and one that is cut short: dlopen would map its pages beyond
/// the end of the file, and the process would be killed (SIGBUS) when it touches them.
void check_file(const File& file) {
  const std::filesystem::path& path = file.path();
  const std::uint64_t size = file.size();
  Elf64_Ehdr header;
  if (size < sizeof header) refuse_file(path, fmt::format("a file of {} bytes", size));
  file.read_at(0, std::as_writable_bytes(std::span(&header, 1)));
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
    refuse_file(path, "a file of another kind");
  if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_ident[EI_DATA] != ELFDATA2LSB ||
      header.e_type != ET_DYN || header.e_phentsize != sizeof(Elf64_Phdr))
    refuse_file(path, "an ELF file of another kind");

  std::vector<Elf64_Phdr> segments(header.e_phnum);
  const std::uint64_t table_bytes = segments.size() * sizeof(Elf64_Phdr);
  if (header.e_phoff > size || table_bytes > size - header.e_phoff)
    refuse_file(path, fmt::format("one that is cut short at {} bytes", size));
  file.read_at(header.e_phoff, std::as_writable_bytes(std::span(segments)));
  for (const Elf64_Phdr& segment : segments)
    if (segment.p_type == PT_LOAD &&
        (segment.p_offset > size || segment.p_filesz > size - segment.p_offset))
      refuse_file(path, fmt::format("one that is cut short at {} bytes", size));
}

/// Only a regular file: opening a FIFO would block.
File open_plugin_file(const std::filesystem::path& path) {
  try {
    return File(path, OpenMode::kRead);
  } catch (const Error& error) {
    throw Error(error, fmt::format("load plug-in: {}", error.what()));
  }
}

/// The loader's text for its last error.
std::string loader_error() {
  const char* const text = ::dlerror();  // NOLINT(concurrency-mt-unsafe): glibc keeps it per thread
  return text == nullptr ? "an unknown error of the loader" : text;
}

}  // namespace

OpenPlugin open_plugin(const std::filesystem::path& path) {
  // dlopen would search the system's folders for a name without '/'.
  const std::filesystem::path absolute = absolute_path(path);
  check_file(open_plugin_file(path));
  OpenPlugin plugin;
  plugin.handle = ::dlopen(absolute.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (plugin.handle == nullptr) refuse_file(path, "one that the loader refuses: " + loader_error());
  plugin.entry = reinterpret_cast<PluginFunction>(::dlsym(plugin.handle, kEntryName));
  if (plugin.entry == nullptr)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("load plug-in {}: expected the function {}, found none: this is no "
                            "plug-in, or one for another version of plait",
                            path.native(), kEntryName));
  return plugin;
}

PLAIT_END_NAMESPACE
