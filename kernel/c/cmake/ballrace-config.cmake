# Imported target ballrace::ballrace of the packed libraries.
#
#   find_package(ballrace REQUIRED PATHS path/to/ballrace-c-VERSION)
#   target_link_libraries(firmware PRIVATE ballrace::ballrace)
#
# BALLRACE_TARGET names the folder in lib/; its default is "host". BALLRACE_SHARED selects the shared library.
get_filename_component(ballrace_root "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
if(NOT BALLRACE_TARGET)
  if(CMAKE_CROSSCOMPILING)
    set(ballrace_FOUND FALSE)
    set(ballrace_NOT_FOUND_MESSAGE
      "BALLRACE_TARGET: empty in a cross build for ${CMAKE_SYSTEM_NAME} ${CMAKE_SYSTEM_PROCESSOR}, expected a folder of ${ballrace_root}/lib")
    return()
  endif()
  set(BALLRACE_TARGET host)
endif()
set(ballrace_folder "${ballrace_root}/lib/${BALLRACE_TARGET}")
if(NOT IS_DIRECTORY "${ballrace_folder}")
  set(ballrace_FOUND FALSE)
  set(ballrace_NOT_FOUND_MESSAGE "no library of BALLRACE_TARGET \"${BALLRACE_TARGET}\" in ${ballrace_root}/lib")
  return()
endif()
if(NOT TARGET ballrace::ballrace)
  if(BALLRACE_SHARED)
    file(GLOB ballrace_library "${ballrace_folder}/*.so" "${ballrace_folder}/*.dylib" "${ballrace_folder}/*.dll")
    add_library(ballrace::ballrace SHARED IMPORTED)
  else()
    set(ballrace_library "${ballrace_folder}/libballrace_c.a")
    add_library(ballrace::ballrace STATIC IMPORTED)
    if(BALLRACE_TARGET STREQUAL "host" AND UNIX)
      set_target_properties(ballrace::ballrace PROPERTIES INTERFACE_LINK_LIBRARIES "m;pthread;dl")
    endif()
  endif()
  set_target_properties(ballrace::ballrace PROPERTIES
    IMPORTED_LOCATION "${ballrace_library}"
    IMPORTED_NO_SONAME TRUE
    INTERFACE_INCLUDE_DIRECTORIES "${ballrace_root}/include")
endif()
