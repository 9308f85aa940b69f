// Pages as HTML.
#include <fmt/format.h>

#include <boost/algorithm/string/replace.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "instrument/page.h"

namespace plait::instrument {

/// page/style.css, as CMake made it a source.
extern const char* const kPageStyle;

namespace {

using nlohmann::ordered_json;

/// The same text with replacement characters for what is not UTF-8, and without control characters.
std::string valid_text(std::string_view text) {
  const ordered_json quoted(std::string{text});
  std::string valid =
      ordered_json::parse(quoted.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  for (char& character : valid)
    if (static_cast<unsigned char>(character) < 0x20 && character != '\n') character = ' ';
  return valid;
}

std::string_view class_of(Tone tone) {
  constexpr std::string_view kClasses[] = {"plain", "good", "doubt", "failed"};
  return kClasses[static_cast<std::size_t>(tone)];
}

const char* class_of_column(const Table::Column& column) {
  return column.number ? " class=\"number\"" : "";
}

}  // namespace

std::string escape_html(std::string_view text) {
  constexpr std::pair<const char*, const char*> kEntities[] = {
      {"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}};
  std::string escaped = valid_text(text);
  for (const auto& [character, entity] : kEntities)  // '&' first: the others bring one
    boost::replace_all(escaped, character, entity);
  return escaped;
}

namespace {

/// Writes the parts of a page, one after another.
class HtmlWriter {
 public:
  void operator()(const Verdict& part) {
    failed = failed || part.tone == Tone::kFailed;
    body += fmt::format("<p class=\"verdict {}\">{}</p>\n", class_of(part.tone),
                        escape_html(part.text));
  }
  void operator()(const Section& part) {
    body += fmt::format("<h2>{}</h2>\n", escape_html(part.heading));
  }
  void operator()(const Paragraph& part) {
    body += fmt::format("<p>{}</p>\n", escape_html(part.text));
  }
  void operator()(const List& part) {
    if (part.items.empty()) return;
    body += fmt::format("<ul class=\"{}\">\n", class_of(part.tone));
    for (const std::string& item : part.items)
      body += fmt::format("<li>{}</li>\n", escape_html(item));
    body += "</ul>\n";
  }
  void operator()(const Command& part) {
    if (!part.text.empty()) body += fmt::format("<pre>{}</pre>\n", escape_html(part.text));
  }
  void operator()(const Picture&) {}
  void operator()(const Table& table) { add_figure(table.caption, rows_of(table)); }
  void operator()(const auto& plot) {
    if (plot.points.empty()) return;
    add_figure(plot.caption,
               fmt::format("<div class=\"plot\">{}</div>\n", svg_plot(plot, series_)));
  }

  bool failed = false;
  std::string body;

 private:
  void add_figure(const Caption& caption, const std::string& content) {
    body += "<figure>\n";
    if (!caption.title.empty())
      body += fmt::format("<figcaption><strong>{}</strong><p>{}</p></figcaption>\n",
                          escape_html(caption.title), escape_html(caption.how_to_read));
    body += content;
    (*this)(Command{caption.command});
    body += "</figure>\n";
  }

  static std::string rows_of(const Table& table) {
    std::string rows = "<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>";
    for (const Table::Column& column : table.columns)
      rows += fmt::format("<th scope=\"col\"{}>{}</th>", class_of_column(column),
                          escape_html(column.name));
    rows += "</tr></thead>\n<tbody>\n";
    for (const Table::Row& row : table.rows) {
      rows += fmt::format("<tr class=\"{}\">", class_of(row.tone));
      for (std::size_t at = 0; at < row.cells.size() && at < table.columns.size(); ++at)
        rows += fmt::format("<td{}>{}</td>", class_of_column(table.columns[at]),
                            escape_html(row.cells[at]));
      rows += "</tr>\n";
    }
    return rows + "</tbody>\n</table></div>\n";
  }

  SeriesNames series_;
};

}  // namespace

std::string to_html(const Page& page) {
  HtmlWriter writer;
  for (const Part& part : page.parts) std::visit(writer, part);
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{}{}</title>\n<style>\n{}</style>\n</head>\n"
      "<body{}>\n<h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n{}</body>\n</html>\n",
      writer.failed ? "FAILED: " : "", escape_html(page.title), kPageStyle,
      writer.failed ? " class=\"failed\"" : "", escape_html(page.title), escape_html(page.subtitle),
      writer.body);
}

}  // namespace plait::instrument
