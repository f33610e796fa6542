# Runs Doxygen and fails where it warns. Functions and members may speak for themselves; a class or
# an enumeration without a comment, and whatever else Doxygen says, is a mistake.
file(REMOVE_RECURSE ${DOCS}/html)
file(MAKE_DIRECTORY ${DOCS})
execute_process(COMMAND ${DOXYGEN} ${DOXYFILE} RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${DOXYGEN} ends with ${status}")
endif()
file(STRINGS ${DOCS}/warnings.txt warnings)
list(FILTER warnings EXCLUDE REGEX "Member .*[(](function|variable|typedef|friend|enumvalue)[)].* is not documented[.]$")
# Those of a class have values that say what they are.
list(FILTER warnings EXCLUDE REGEX "[(]enumeration[)] of (class|struct) .* is not documented[.]$")
if(warnings)
  list(JOIN warnings "\n" text)
  message(FATAL_ERROR "Doxygen warns:\n${text}")
endif()
message(STATUS "${DOCS}/html/index.html")
