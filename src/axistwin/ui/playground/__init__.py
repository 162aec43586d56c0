"""The playground: axistwin in a web page, executed by Pyodide in the browser, without a server."""
