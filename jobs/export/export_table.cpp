// The job "export".
#include <algorithm>

#include "export/export_mesh.h"
#include "export/part_text.h"
#include "job.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// "a,b" is two names.
void add_names(std::vector<std::string>& names, const std::string& text) {
  for (std::size_t first = 0; first <= text.size();) {
    const std::size_t end = std::min(text.find(',', first), text.size());
    names.push_back(text.substr(first, end - first));
    first = end + 1;
  }
}

struct ExportArguments : ExportRequest {
  std::vector<std::string> attribute, face_attribute;
};

JobReport run_export(ExportArguments& arguments, const JobCall& call) {
  for (const std::string& text : arguments.attribute) add_names(arguments.attributes, text);
  for (const std::string& text : arguments.face_attribute)
    add_names(arguments.face_attributes, text);
  const ExportResult done = export_mesh(arguments, call.open_backends, call.watch);
  return {{"store", arguments.store.string()},
          {"file", done.file.string()},
          {"level", done.level},
          {"patches", done.patches},
          {"vertices", done.vertices},
          {"faces", done.triangles},
          {"file_bytes", done.file_bytes},
          {"position_error", done.moved.most},
          {"moved", done.moved.count},
          {"side_normals", done.side_normals},
          {"left_out", done.left_out}};
}

}  // namespace

Job export_job() {
  JobTable<ExportArguments> table("export", "Write one level of a store as a mesh file");
  table.path("input", &ExportArguments::store, "The store").at(0).required();
  table
      .output("output", &ExportArguments::output,
              "The file to make: NAME.(ply|obj|stl|off)[.gz|.zst], "
              "NAME.(vtp|pvtp|glb|gltf)")
      .at(1)
      .required();
  table.count("level", &ExportArguments::level, 0, kMaxLevel, "The level; default: the finest");
  table.texts("attribute", &ExportArguments::attribute,
              "Also write this attribute, such as normal; for more, repeat the option or give a,b");
  table.texts("face-attribute", &ExportArguments::face_attribute,
              "Also write this attribute of the base faces as one of the triangles (PLY and VTK "
              "only); for more, repeat the option or give a,b");
  table
      .named(
          "box",
          [](ExportArguments& arguments, const std::string& text) {
            arguments.box = parse_box(text);
          },
          "Only patches that reach into this box")
      .shown_as("X,Y,Z,X,Y,Z");
  table
      .named(
          "faces",
          [](ExportArguments& arguments, const std::string& text) {
            arguments.faces = parse_faces(text);
          },
          "Only the patches of these base faces, such as 0,7,20-29")
      .shown_as("LIST");
  table.flag("quantize", &ExportArguments::quantize,
             "glTF: coordinates in 16 bits and normals in 8 (KHR_mesh_quantization)");
  table
      .text("colors", &ExportArguments::colors,
            "glTF, whose colours are linear: what the numbers of color are; sRGB is converted. "
            "Default: srgb for integers, linear for floats")
      .shown_as("srgb|linear");
  table
      .text("up", &ExportArguments::up,
            "glTF, where y points upwards: the axis of the store that does; z is turned to y")
      .shown_as("y|z")
      .by_default("y");
  table.flag("narrow", &ExportArguments::narrow, "glTF: write attributes of float64 as float32");
  table.force(&ExportArguments::existing, "Replace files that exist", "replaces files");
  table.count("pieces", &ExportArguments::pieces, 1, 64,
              "PVTP: the number of .vtp files; default: one for 4 million triangles");
  table.bytes("memory", &ExportArguments::budget_bytes, "Budget for blocks in memory");
  return table.run(run_export);
}

PLAIT_END_NAMESPACE
