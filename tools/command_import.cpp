// plait import: makes a store of a mesh that is semi-regular already.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "arguments.h"
#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string import_text(const nlohmann::ordered_json& report) {
  const auto word = [&](const char* name) { return report[name].get<std::string>(); };
  const auto count = [&](const char* name) {
    return format_count(report[name].get<std::uint64_t>());
  };
  const auto seconds = [&](const char* name) { return report[name].get<double>(); };
  std::string attributes;
  for (const auto& attribute : report["attributes"])
    attributes += fmt::format(
        "{}{} {} x {}", attributes.empty() ? "" : ", ", attribute["name"].get<std::string>(),
        attribute["type"].get<std::string>(), attribute["components"].get<std::uint32_t>());
  const int base_level = report["base_level"].get<int>();
  std::string text = fmt::format(
      "{}: {} vertices, {} level{} over {} vertices and {} faces; {}\n{}: {} by backend {} ({}), "
      "{:.2f} s to read, {:.2f} s to find the levels, {:.2f} s to write\n",
      word("mesh"), count("vertices"), report["levels"].get<int>() - base_level,
      report["levels"].get<int>() - base_level == 1 ? "" : "s", count("base_vertices"),
      count("base_faces"), attributes, word("store"),
      format_bytes(report["stored_bytes"].get<std::uint64_t>()), word("backend"),
      word("backend_reason"), seconds("read_seconds"), seconds("recover_seconds"),
      seconds("write_seconds"));
  if (base_level > 0)
    text += fmt::format("level {} is the base mesh of the store, so that slots stay small\n",
                        base_level);
  if (report["had_choice"].get<bool>())
    text += "several base meshes are equally deep: this one keeps the smallest vertex numbers\n";
  if (const std::string next = word("next_level"); !next.empty()) text += next + "\n";
  return text;
}

}  // namespace

void add_import_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"import",
       backend_help(context.backends) + compression_help() +
           "\n"
           "The triangles of INPUT must be those of a coarser mesh, each split into four at the "
           "middles\n"
           "of its sides, again and again; vertices may lie anywhere, and vertices, faces and "
           "corners\n"
           "may come in any order. Corners of STL files with equal positions are one vertex.\n"
           "The command finds the coarsest mesh, or the mesh N levels below INPUT. Numbers of "
           "INPUT keep\n"
           "their bits; --precision float32 narrows positions. Vertex properties of PLY files "
           "become\n"
           "attributes: nx ny nz \"normal\", "
           "red\n"
           "green blue alpha \"color\", s t or u v \"texture\", NAME_0 NAME_1 ... \"NAME\", and "
           "all "
           "others\n"
           "their own names; plait export writes them again.\n"
           "A mesh without levels is refused, and the message says where the levels end: plait "
           "remesh\n"
           "makes levels for such a mesh.\n"
           "The mesh must fit into the memory, with 100 bytes for each vertex.\n"
           "\n"
           "Examples:\n"
           "  plait import sculpture.ply sculpture.plait\n"
           "  plait import sculpture.obj.gz sculpture.plait --levels 3\n"
           "  plait import part.stl part.plait --compress small --memory 1GiB",
       import_text});
}

}  // namespace plait
