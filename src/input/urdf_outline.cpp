#include <expat.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "core/lists.hpp"
#include "input/urdf_reader.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_depth = 256;      // real robots stay below 10
constexpr int most_attributes = 1000;        // of one element
constexpr std::size_t most_nodes = 1000000;  // elements and attributes kept: about 27000 links

/// A place in the text that moves forward, so that a document needs one pass.
struct Cursor {
  std::size_t byte = 0;
  int line = 1, column = 1;

  void advance(const std::string& text, std::size_t to) {
    if (to < byte) *this = Cursor{};
    for (to = std::min(to, text.size()); byte < to; ++byte) {
      if (text[byte] == '\n') {
        ++line;
        column = 1;
      } else if ((static_cast<unsigned char>(text[byte]) & 0xC0u) != 0x80u) {
        ++column;
      }
    }
  }
};

/// Builds the outline from events of expat. Exceptions must not pass through C code: they are stored until
/// expat returns.
class Outliner {
 public:
  Outliner(const std::string& text, const std::string& file) : text_(text), file_(file) {}
  UrdfElement run();

 private:
  static void on_start(void* self, const XML_Char* name, const XML_Char** attributes) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] { outliner.start(name, attributes); });
  }
  static void on_end(void* self, const XML_Char*) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] { outliner.end(); });
  }
  static void on_text(void* self, const XML_Char* text, int length) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] { outliner.add_text({text, static_cast<std::size_t>(length)}); });
  }
  static void on_doctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    auto& outliner = *static_cast<Outliner*>(self);
    outliner.guarded([&] {
      outliner.fail("a document type declaration (DTD) is not allowed", "<!DOCTYPE",
                    "remove it: a URDF needs none");
    });
  }

  template <class Action>
  void guarded(Action&& action) {
    if (thrown_) return;
    try {
      action();
    } catch (...) {
      thrown_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  void start(const XML_Char* name, const XML_Char** attributes);
  void end();
  void add_text(std::string_view text);
  void read_attributes(UrdfElement& element, const XML_Char** attributes);
  [[noreturn]] void malformed();
  [[noreturn]] void fail(std::string rule, std::string found, std::string remedy) {
    cursor_.advance(text_, std::max<XML_Index>(0, XML_GetCurrentByteIndex(parser_.get())));
    throw Error({file_, cursor_.line, cursor_.column}, "", std::move(rule), std::move(found),
                std::move(remedy));
  }

  const std::string& text_;
  const std::string& file_;
  // "UTF-8" overrides the XML declaration: check_text has verified the encoding.
  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_{XML_ParserCreate("UTF-8"),
                                                                       &XML_ParserFree};
  Cursor cursor_;
  std::exception_ptr thrown_;
  std::vector<std::pair<std::string, int>> open_;  ///< every open element and its line
  std::vector<UrdfElement> kept_;                  ///< open elements that are read, outermost first
  std::size_t whole_from_ = 0;                     ///< size of kept_ inside a whole element; 0: outside
  std::optional<UrdfElement> root_;
  std::size_t nodes_ = 0;
};

UrdfElement Outliner::run() {
  if (!parser_) throw std::bad_alloc();
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), &on_start, &on_end);
  XML_SetCharacterDataHandler(parser_.get(), &on_text);
  XML_SetStartDoctypeDeclHandler(parser_.get(), &on_doctype);
  const auto status = XML_Parse(parser_.get(), text_.data(), static_cast<int>(text_.size()), 1);
  if (thrown_) std::rethrow_exception(thrown_);
  if (status != XML_STATUS_OK || !root_) malformed();
  return std::move(*root_);
}

void Outliner::start(const XML_Char* name, const XML_Char** attributes) {
  const std::string_view tag = name;
  if (open_.size() >= most_depth) fail("elements are nested more than 256 deep", "", "");
  if (XML_GetSpecifiedAttributeCount(parser_.get()) > 2 * most_attributes)
    fail("an element has more than 1000 attributes", "<" + std::string(tag) + ">", "");
  if (tag.starts_with("xacro:"))
    fail("this is a xacro template, not a URDF", "<" + std::string(tag) + ">",
         "install xacro (pip install xacro, or with ROS), and it is expanded when it is read; or expand it "
         "elsewhere: xacro FILE.xacro > FILE.urdf");
  if (open_.empty() && tag != "robot") {
    const std::string kind = tag == "sdf"      ? "this is an SDF file, not a URDF"
                             : tag == "mujoco" ? "this is a MuJoCo (MJCF) file, not a URDF"
                                               : "the root element of a URDF is <robot>";
    fail(kind, "<" + std::string(tag) + ">",
         tag == "sdf"
             ? "convert it first: sdf2urdf.py FILE.sdf FILE.urdf, of the ROS package pysdf (not that of pip)"
         : tag == "mujoco" ? "convert it first: pip install mjcf-urdf-simple-converter, then in Python "
                             "mjcf_urdf_simple_converter.convert('FILE.xml', 'FILE.urdf')"
                           : "");
  }
  const Vocabulary* parent = kept_.empty() || whole_from_ > 0 ? nullptr : vocabulary(kept_.back().name);
  const bool inside_kept = kept_.size() == open_.size();
  cursor_.advance(text_, XML_GetCurrentByteIndex(parser_.get()));
  open_.emplace_back(tag, cursor_.line);
  if (!inside_kept) return;
  UrdfElement element{std::string(tag), cursor_.line, cursor_.column, {}, {}};
  if (++nodes_ > most_nodes) fail("the document is too large for a robot", "over a million elements", "");
  const bool whole = parent && Vocabulary::has(parent->whole, tag);
  if (!parent || whole || Vocabulary::has(parent->many, tag) || Vocabulary::has(parent->once, tag)) {
    read_attributes(element, attributes);
    kept_.push_back(std::move(element));
    if (whole) whole_from_ = kept_.size();
  } else if (!Vocabulary::has(parent->ignored, tag)) {
    kept_.back().children.push_back(std::move(element));  // only the name, for the search for misspellings
  }
}

/// Expat gives the place of an element; those of its attributes are found by scanning the well-formed tag.
void Outliner::read_attributes(UrdfElement& element, const XML_Char** attributes) {
  const std::string_view blank = " \t\r\n";
  Cursor cursor = cursor_;
  std::size_t at = text_.find_first_of(" \t\r\n/>", cursor.byte);
  for (; attributes[0] != nullptr; attributes += 2) {
    if (++nodes_ > most_nodes) fail("the document is too large for a robot", "over a million attributes", "");
    at = text_.find_first_not_of(blank, at);
    cursor.advance(text_, at);
    element.attributes.push_back({attributes[0], attributes[1], cursor.line, cursor.column});
    const std::size_t quote = text_.find_first_of("\"'", at);
    at = text_.find(text_[quote], quote + 1) + 1;
  }
}

void Outliner::end() {
  const bool closes_kept = kept_.size() == open_.size();
  open_.pop_back();
  if (!closes_kept) return;
  if (kept_.size() == whole_from_) whole_from_ = 0;
  UrdfElement element = std::move(kept_.back());
  kept_.pop_back();
  if (kept_.empty())
    root_ = std::move(element);
  else
    kept_.back().children.push_back(std::move(element));
}

void Outliner::add_text(std::string_view text) {
  if (whole_from_ > 0 && kept_.size() == open_.size()) kept_.back().text += text;
}

void Outliner::malformed() {
  const XML_Error code = XML_GetErrorCode(parser_.get());
  if (code == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
  const std::string open = open_.empty() ? ""
                                         : "<" + open_.back().first + "> of line " +
                                               std::to_string(open_.back().second) + " is still open";
  const std::size_t first = text_.find_first_not_of(" \t\r\n");
  const bool other_language = first != std::string::npos && text_[first] != '<';
  if (other_language && (code == XML_ERROR_SYNTAX || code == XML_ERROR_INVALID_TOKEN))
    fail("this is not a URDF: a URDF is XML and begins with <robot>", "",
         "name the file of the robot, not of a spec");
  switch (code) {
    case XML_ERROR_NO_ELEMENTS:
      if (open_.empty()) fail("the document is empty: a URDF must have a <robot>", "", "");
      fail("unexpected end of the document", "", open);
    case XML_ERROR_SYNTAX:
      fail("the XML is malformed here", "", "write tags as <name ...> or <name .../>");
    case XML_ERROR_INVALID_TOKEN:
      fail("the XML is malformed here", "",
           "put the value of every attribute in quotation marks, and write &amp; for &, &lt; for <");
    case XML_ERROR_TAG_MISMATCH:
      fail("the closing tag does not match", "", open);
    case XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
      fail("nothing may follow </robot>", "", "a URDF must have <robot> as its only root element");
    case XML_ERROR_MISPLACED_XML_PI:
      fail("<?xml ...?> must be at the start of the file", "", "remove the text before it");
    default:
      fail(std::string("the XML is malformed: ") + XML_ErrorString(code), "", "");
  }
}

}  // namespace

const UrdfAttribute* UrdfElement::attribute(std::string_view wanted) const {
  return find_named(attributes, wanted);
}

const UrdfElement* UrdfElement::child(std::string_view wanted) const { return find_named(children, wanted); }

std::string UrdfElement::title() const {
  const UrdfAttribute* given = attribute("name");
  return given ? name + " '" + given->value + "'" : name;
}

UrdfElement urdf_outline(const std::string& text, const std::string& file) {
  return Outliner(text, file).run();
}

}  // namespace qerr
