# Writes a JSON file as C++, in pieces because the length of a literal is limited.
file(READ ${FROM} text)
string(LENGTH "${text}" length)
set(pieces "")
set(at 0)
while(at LESS length)
  string(SUBSTRING "${text}" ${at} 8000 piece)
  string(APPEND pieces "R\"~~(${piece})~~\"\n")
  math(EXPR at "${at} + 8000")
endwhile()
file(WRITE ${TO} "#include <string_view>
namespace multitetra {
extern const std::string_view kOpenApiText;
const std::string_view kOpenApiText = ${pieces};
}  // namespace multitetra
")
